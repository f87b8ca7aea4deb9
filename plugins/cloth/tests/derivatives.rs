//! Forces against differences of the energy and matrices against differences of the forces, for all frame rules and a strongly
//! orthotropic sheet.

use pliant_cloth::Cloth;
use pliant_plugin_api::TangentScale;
use pliant_plugin_api::kit::{self, Body};

const STIFFNESS: TangentScale = TangentScale { stiffness: 1.0, damping: 0.0 };
/// Values of the parameter `bending`: none, and hinges that are not coupled.
const UNBENT: f64 = 2.0;
const HINGES: f64 = 1.0;
const SHEET: [(&str, f64); 5] =
    [("young-warp", 1000.0), ("young-weft", 60.0), ("poisson", 0.9), ("shear", 25.0), ("damping-time", 0.0)];

/// Parameters and deformation of a sheet.
struct Case {
    /// Value of the parameter `frame`.
    frame: f64,
    /// Value of the parameter `bending`.
    bending: f64,
    /// Stretch along the warp.
    stretch: f64,
}

/// All frame rules, in tension and compression, with and without hinges.
fn cases() -> impl Iterator<Item = Case> {
    [0.0, 1.0, 2.0].into_iter().flat_map(|frame| {
        [1.15, 0.8]
            .into_iter()
            .flat_map(move |stretch| [UNBENT, HINGES].map(move |bending| Case { frame, bending, stretch }))
    })
}

/// The cases without hinges, whose matrix has another approximation.
fn membranes() -> impl Iterator<Item = Case> {
    cases().filter(|case| case.bending == UNBENT)
}

fn cloth(frame: f64, tangent: f64, bending: f64) -> Cloth {
    let own = [("frame", frame), ("tangent", tangent), ("bending", bending), ("bending-warp", 1e-3)];
    kit::material(&[&SHEET[..], &own].concat()).unwrap()
}

/// A sheet without bending that wrinkles in compression.
fn wrinkling(frame: f64) -> Cloth {
    let own = [("frame", frame), ("compression", 0.1), ("bending", UNBENT)];
    kit::material(&[&SHEET[..], &own].concat()).unwrap()
}

/// A sheet in a deformed state.
fn deformed(material: &Cloth, stretch: f64) -> Body {
    let sheet = kit::sheet([2, 2], 0.01);
    let mut body = Body::new(material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    for (n, x) in body.x.iter_mut().enumerate() {
        let wave = |i: usize| 0.0015 * (1.7 * n as f64 + 2.3 * i as f64).sin();
        *x = [stretch * x[0] + 0.3 * x[1] + wave(0), x[1] + wave(1), 0.2 * x[0] + wave(2)];
    }
    body
}

/// `a - b`
fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The largest magnitude.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

#[test]
fn forces_are_minus_the_gradient_of_the_energy() {
    let wrinkled = cases().map(|case| (wrinkling(case.frame), case));
    let sheets = cases().map(|case| (cloth(case.frame, 0.0, case.bending), case)).chain(wrinkled);
    for (material, Case { frame, stretch, .. }) in sheets {
        let body = deformed(&material, stretch);
        let force: Vec<f64> = body.forces(&material).unwrap().into_iter().flatten().collect();
        for (i, f) in force.iter().enumerate() {
            let energy_at = |step: f64| {
                let mut moved = body.clone();
                moved.x[i / 3][i % 3] += step;
                moved.energy(&material).unwrap()
            };
            let difference = (energy_at(-1e-7) - energy_at(1e-7)) / 2e-7;
            assert!((f - difference).abs() < 1e-6 * largest(&force), "{frame} {stretch}: {f} {difference}");
        }
    }
}

/// `-df/dx` by central differences, a dense row-major matrix.
fn force_differences(material: &Cloth, body: &Body) -> Vec<f64> {
    let width = 3 * body.x.len();
    let mut dense = vec![0.0; width * width];
    for column in 0..width {
        let forces_at = |step: f64| {
            let mut moved = body.clone();
            moved.x[column / 3][column % 3] += step;
            moved.forces(material).unwrap()
        };
        let (plus, minus) = (forces_at(1e-7), forces_at(-1e-7));
        for row in 0..width {
            dense[row * width + column] = (minus[row / 3][row % 3] - plus[row / 3][row % 3]) / 2e-7;
        }
    }
    dense
}

/// Whether a symmetric matrix with `shift` added to its diagonal is positive definite: whether it has a Cholesky factor.
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
fn the_projected_matrix_is_positive_and_not_softer_than_the_exact_one() {
    let mut indefinite = 0;
    for Case { frame, stretch, bending } in membranes() {
        let (material, projected) = (cloth(frame, 1.0, bending), cloth(frame, 0.0, bending));
        let body = deformed(&material, stretch);
        let n = 3 * body.x.len();
        let exact = body.tangent(&material, STIFFNESS).unwrap();
        let error = difference(&exact, &force_differences(&material, &body));
        assert!(largest(&error) < 2e-6 * largest(&exact), "{frame} {stretch}: {}", largest(&error) / largest(&exact));
        let projected = body.tangent(&projected, STIFFNESS).unwrap();
        let excess = difference(&projected, &exact);
        assert!(is_definite(&projected, n, 1e-10 * largest(&projected)), "{frame} {stretch}");
        assert!(is_definite(&excess, n, 1e-10 * largest(&projected)), "{frame} {stretch}");
        indefinite += usize::from(!is_definite(&exact, n, 1e-6 * largest(&exact)));
    }
    assert!(indefinite > 0, "no exact matrix was indefinite, so nothing was projected");
}

#[test]
fn the_matrix_of_hinges_is_exact_at_rest() {
    let material = cloth(0.0, 0.0, 1.0);
    let sheet = kit::sheet([2, 2], 0.01);
    let body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    let k = body.tangent(&material, STIFFNESS).unwrap();
    let error = difference(&k, &force_differences(&material, &body));
    assert!(largest(&error) < 1e-5 * largest(&k), "{}", largest(&error) / largest(&k));
}

#[test]
fn the_matrix_of_wrinkles_is_positive_and_not_softer_than_the_exact_one() {
    for Case { frame, stretch, .. } in membranes() {
        let material = wrinkling(frame);
        let body = deformed(&material, stretch);
        let n = 3 * body.x.len();
        let k = body.tangent(&material, STIFFNESS).unwrap();
        let excess = difference(&k, &force_differences(&material, &body));
        assert!(is_definite(&k, n, 1e-10 * largest(&k)), "{frame} {stretch}");
        assert!(is_definite(&excess, n, 2e-6 * largest(&k)), "{frame} {stretch}");
        assert!(largest(&excess) > 1e-3 * largest(&k), "{frame} {stretch}: nothing wrinkled");
    }
}
