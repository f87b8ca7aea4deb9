//! The promises of the border, and what the matrix of an implicit step must be.

use pliant_neo_hookean::NeoHookean;
use pliant_plugin_api::kit::{self, Body, CountingAllocator};
use pliant_plugin_api::{AsMaterial, TangentScale};

#[global_allocator]
static COUNTING: CountingAllocator = CountingAllocator;

#[test]
fn conformance() {
    kit::check::<AsMaterial<NeoHookean>>();
}

/// The smallest `u^T K u / u^T u` over many directions, with K of a body whose nodes are scattered.
fn softest(tangent: f64) -> f64 {
    let material: NeoHookean = kit::material(&[("tangent", tangent), ("poisson", 0.49)]).unwrap();
    let block = kit::block([1, 1, 1], 0.01, 0);
    let mut body = Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
    body.x.iter_mut().for_each(|x| *x = [-0.5 * x[0], 0.4 * x[1] + 0.3 * x[0], 0.9 * x[2]]);
    let k = body.tangent(&material, TangentScale { stiffness: 1.0, damping: 0.0 }).unwrap();
    let n = 3 * body.x.len();
    let quotient = |u: &[f64]| {
        let ku = |i: usize| (0..n).map(|j| k[i * n + j] * u[j]).sum::<f64>();
        (0..n).map(|i| u[i] * ku(i)).sum::<f64>() / u.iter().map(|u| u * u).sum::<f64>()
    };
    // Power iteration away from the largest eigenvalue finds the smallest.
    let top: f64 = k.chunks(n).map(|row| row.iter().map(|v| v.abs()).sum::<f64>()).fold(0.0, f64::max);
    let mut u: Vec<f64> = (0..n).map(|i| (i as f64 * 1.7).sin()).collect();
    for _ in 0..4000 {
        let next: Vec<f64> = (0..n).map(|i| top * u[i] - (0..n).map(|j| k[i * n + j] * u[j]).sum::<f64>()).collect();
        let size = next.iter().map(|v| v * v).sum::<f64>().sqrt();
        u = next.into_iter().map(|v| v / size).collect();
    }
    quotient(&u) / top
}

#[test]
fn projected_matrix_has_no_negative_part_and_the_exact_one_may() {
    assert!(softest(0.0) > -1e-9, "{}", softest(0.0));
    assert!(softest(1.0) < -1e-3, "a body turned inside out pushes: {}", softest(1.0));
}
