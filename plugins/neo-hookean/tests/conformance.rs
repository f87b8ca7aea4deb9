//! The conformance suite, and the definiteness of the stiffness matrix.

use pliant_neo_hookean::NeoHookean;
use pliant_plugin_api::kit::{self, Body, CountingAllocator};
use pliant_plugin_api::{AsMaterial, TangentScale};

#[global_allocator]
static COUNTING: CountingAllocator = CountingAllocator;

#[test]
fn conformance() {
    kit::check::<AsMaterial<NeoHookean>>();
}

/// The smallest eigenvalue of the stiffness matrix of an inverted, distorted block, relative to a bound on its largest, with a value of the
/// parameter `tangent`.
fn smallest_eigenvalue(tangent: f64) -> f64 {
    let material: NeoHookean = kit::material(&[("tangent", tangent), ("poisson", 0.49)]).unwrap();
    let block = kit::block([1, 1, 1], 0.01, 0);
    let mut body = Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
    body.x.iter_mut().for_each(|x| *x = [-0.5 * x[0], 0.4 * x[1] + 0.3 * x[0], 0.9 * x[2]]);
    let k = body.tangent(&material, TangentScale { stiffness: 1.0, damping: 0.0 }).unwrap();
    let n = 3 * body.x.len();
    let rayleigh_quotient = |u: &[f64]| {
        let ku = |i: usize| (0..n).map(|j| k[i * n + j] * u[j]).sum::<f64>();
        (0..n).map(|i| u[i] * ku(i)).sum::<f64>() / u.iter().map(|u| u * u).sum::<f64>()
    };
    // Power iteration with `bound I - K`. The bound is the largest row sum (Gershgorin 1931).
    let bound: f64 = k.chunks(n).map(|row| row.iter().map(|v| v.abs()).sum::<f64>()).fold(0.0, f64::max);
    let mut u: Vec<f64> = (0..n).map(|i| (i as f64 * 1.7).sin()).collect();
    for _ in 0..4000 {
        let next: Vec<f64> = (0..n).map(|i| bound * u[i] - (0..n).map(|j| k[i * n + j] * u[j]).sum::<f64>()).collect();
        let norm = next.iter().map(|v| v * v).sum::<f64>().sqrt();
        u = next.into_iter().map(|v| v / norm).collect();
    }
    rayleigh_quotient(&u) / bound
}

#[test]
fn the_projected_matrix_is_positive_where_the_exact_one_is_not() {
    let (projected, exact) = (smallest_eigenvalue(0.0), smallest_eigenvalue(1.0));
    assert!(projected > -1e-9, "{projected}");
    assert!(exact < -1e-3, "the exact matrix of an inverted block is positive: {exact}");
}
