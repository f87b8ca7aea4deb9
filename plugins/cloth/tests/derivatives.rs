//! Energy, force and matrix against each other's differences, for every frame and a sheet that is far from isotropic.

use pliant_cloth::Cloth;
use pliant_plugin_api::TangentScale;
use pliant_plugin_api::kit::{self, Body};

const STIFFNESS: TangentScale = TangentScale { stiffness: 1.0, damping: 0.0 };
const SHEET: [(&str, f64); 5] =
    [("young-warp", 1000.0), ("young-weft", 60.0), ("poisson", 0.9), ("shear", 25.0), ("damping-time", 0.0)];

/// The frames, and a body in a deformed state for each.
fn cases() -> impl Iterator<Item = (f64, f64, f64)> {
    let frames = [0.0, 1.0, 2.0].into_iter();
    frames.flat_map(|frame| [1.15, 0.8].into_iter().flat_map(move |s| [2.0, 1.0].map(move |b| (frame, s, b))))
}

fn cloth(frame: f64, tangent: f64, bending: f64) -> Cloth {
    let own = [("frame", frame), ("tangent", tangent), ("bending", bending), ("bending-warp", 1e-3)];
    kit::material(&[&SHEET[..], &own].concat()).unwrap()
}

/// The same that gives way to compression.
fn wrinkling(frame: f64) -> Cloth {
    let own = [("frame", frame), ("compression", 0.1), ("bending", 2.0)];
    kit::material(&[&SHEET[..], &own].concat()).unwrap()
}

fn deformed(material: &Cloth, stretch: f64) -> Body {
    let sheet = kit::sheet([2, 2], 0.01);
    let mut body = Body::new(material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    for (n, x) in body.x.iter_mut().enumerate() {
        let wave = |i: usize| 0.0015 * (1.7 * n as f64 + 2.3 * i as f64).sin();
        *x = [stretch * x[0] + 0.3 * x[1] + wave(0), x[1] + wave(1), 0.2 * x[0] + wave(2)];
    }
    body
}

/// The largest entry without its sign.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

#[test]
fn forces_are_the_slope_of_the_energy() {
    let wrinkled = cases().map(|(frame, stretch, _)| (frame, stretch, wrinkling(frame)));
    let sheets = cases().map(|(frame, stretch, bending)| (frame, stretch, cloth(frame, 0.0, bending))).chain(wrinkled);
    for (frame, stretch, material) in sheets {
        let body = deformed(&material, stretch);
        let force: Vec<f64> = body.forces(&material).unwrap().into_iter().flatten().collect();
        for (i, pull) in force.iter().enumerate() {
            let at = |step: f64| {
                let mut moved = body.clone();
                moved.x[i / 3][i % 3] += step;
                moved.energy(&material).unwrap()
            };
            let slope = (at(-1e-7) - at(1e-7)) / 2e-7;
            assert!((pull - slope).abs() < 1e-6 * largest(&force), "{frame} {stretch}: {pull} {slope}");
        }
    }
}

/// `-df/dx`, dense.
fn slopes(material: &Cloth, body: &Body) -> Vec<f64> {
    let width = 3 * body.x.len();
    let mut dense = vec![0.0; width * width];
    for column in 0..width {
        let at = |step: f64| {
            let mut moved = body.clone();
            moved.x[column / 3][column % 3] += step;
            moved.forces(material).unwrap()
        };
        let (plus, minus) = (at(1e-7), at(-1e-7));
        for row in 0..width {
            dense[row * width + column] = (minus[row / 3][row % 3] - plus[row / 3][row % 3]) / 2e-7;
        }
    }
    dense
}

/// Whether a symmetric matrix with `shift` on its diagonal is positive definite (Cholesky 1910).
fn is_definite(a: &[f64], n: usize, shift: f64) -> bool {
    let mut l = a.to_vec();
    for j in 0..n {
        let pivot = l[j * n + j] + shift - (0..j).map(|k| l[j * n + k] * l[j * n + k]).sum::<f64>();
        if pivot <= 0.0 {
            return false;
        }
        l[j * n + j] = pivot.sqrt();
        for i in j + 1..n {
            let sum: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
            l[i * n + j] = (l[i * n + j] - sum) / l[j * n + j];
        }
    }
    true
}

#[test]
fn exact_matrix_is_the_slope_and_the_projected_one_is_nowhere_softer_nor_negative() {
    let mut negative = 0;
    for (frame, stretch, bending) in cases().filter(|c| c.2 == 2.0) {
        let (material, projected) = (cloth(frame, 1.0, bending), cloth(frame, 0.0, bending));
        let body = deformed(&material, stretch);
        let n = 3 * body.x.len();
        let (k, slope) = (body.tangent(&material, STIFFNESS).unwrap(), slopes(&material, &body));
        let off: Vec<f64> = k.iter().zip(&slope).map(|(k, s)| k - s).collect();
        assert!(largest(&off) < 2e-6 * largest(&k), "{frame} {stretch}: {} {}", largest(&off), largest(&k));
        let over = body.tangent(&projected, STIFFNESS).unwrap();
        let more: Vec<f64> = over.iter().zip(&k).map(|(p, k)| p - k).collect();
        assert!(is_definite(&over, n, 1e-10 * largest(&over)), "{frame} {stretch}");
        assert!(is_definite(&more, n, 1e-10 * largest(&over)), "{frame} {stretch}");
        negative += usize::from(!is_definite(&k, n, 1e-6 * largest(&k)));
    }
    assert!(negative > 0, "no state had a negative part to take away");
}

#[test]
fn hinge_matrix_at_rest_is_the_slope() {
    let material = cloth(0.0, 0.0, 1.0);
    let sheet = kit::sheet([2, 2], 0.01);
    let body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    let (k, slope) = (body.tangent(&material, STIFFNESS).unwrap(), slopes(&material, &body));
    let off: Vec<f64> = k.iter().zip(&slope).map(|(k, s)| k - s).collect();
    assert!(largest(&off) < 1e-5 * largest(&k), "{}", largest(&off) / largest(&k));
}

#[test]
fn wrinkling_matrix_is_nowhere_softer_than_the_slope_nor_negative() {
    for (frame, stretch, _) in cases().filter(|c| c.2 == 2.0) {
        let material = wrinkling(frame);
        let body = deformed(&material, stretch);
        let n = 3 * body.x.len();
        let (k, slope) = (body.tangent(&material, STIFFNESS).unwrap(), slopes(&material, &body));
        let more: Vec<f64> = k.iter().zip(&slope).map(|(k, s)| k - s).collect();
        assert!(is_definite(&k, n, 1e-10 * largest(&k)), "{frame} {stretch}");
        assert!(is_definite(&more, n, 2e-6 * largest(&k)), "{frame} {stretch}");
        assert!(largest(&more) > 1e-3 * largest(&k), "{frame} {stretch}: nothing wrinkled");
    }
}
