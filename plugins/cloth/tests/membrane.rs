//! The membrane of a sheet: patch tests, rigid motion, shear of a trellis, and degenerate states.

mod strip;

use pliant_cloth::Cloth;
use pliant_plugin_api::TangentScale;
use pliant_plugin_api::kit::{self, Body, Sheet};
use strip::{PATTERNS, WIDTH, strip};

const SHEET: [(&str, f64); 6] = [
    ("young-warp", 1000.0),
    ("young-weft", 500.0),
    ("poisson", 0.3),
    ("shear", 50.0),
    ("damping-time", 0.01),
    ("bending", 2.0),
];

/// The sheet of the tests, with further parameters.
fn cloth(more: &[(&str, f64)]) -> Cloth {
    kit::material(&[&SHEET[..], more].concat()).unwrap()
}

/// A square of 0.1 m, and a body of it.
fn square(pattern: strip::Pattern, material: &Cloth) -> (Sheet, Body) {
    let mut sheet = strip(pattern, 8);
    let width = sheet.rest.iter().fold(0.0, |m: f64, x| m.max(x[1]));
    assert!((width / WIDTH - 1.0).abs() < 0.2);
    sheet.rest.iter_mut().for_each(|x| *x = [0.1 * x[0], 0.1 * x[1] / width, 0.0]);
    let triangles: Vec<[u32; 3]> = sheet.triangles.nodes.as_chunks::<3>().0.to_vec();
    let sheet = Sheet::new(sheet.rest, &triangles);
    let body = Body::new(material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    (sheet, body)
}

/// The sum of the forces on the nodes whose rest position is selected, N.
fn sum(sheet: &Sheet, force: &[[f64; 3]], is_selected: impl Fn([f64; 3]) -> bool) -> [f64; 3] {
    let selected = sheet.rest.iter().zip(force).filter(|(x, _)| is_selected(**x)).map(|(_, f)| *f);
    selected.fold([0.0; 3], |s, f| [s[0] + f[0], s[1] + f[1], s[2] + f[2]])
}

/// A homogeneous deformation and its closed form.
struct Patch {
    /// Deformation gradient by rows.
    gradient: [[f64; 2]; 2],
    /// Forces on the sides x = 0.1 and y = 0.1, N.
    right: [f64; 2],
    top: [f64; 2],
    /// Elastic energy of the whole patch, J.
    energy: f64,
}

#[test]
fn patches_are_exact() {
    let material = cloth(&[]);
    let patches = [
        Patch { gradient: [[1.01, 0.0], [0.0, 0.997]], right: [-1.0, 0.0], top: [0.0, 0.0], energy: 5e-4 },
        Patch { gradient: [[0.9985, 0.0], [0.0, 1.01]], right: [0.0, 0.0], top: [0.0, -0.5], energy: 2.5e-4 },
        Patch { gradient: [[1.0, 0.01], [0.01, 1.0]], right: [0.0, -0.1], top: [-0.1, 0.0], energy: 1e-4 },
    ];
    for pattern in PATTERNS {
        let (sheet, mut body) = square(pattern, &material);
        for Patch { gradient: f, right, top, energy } in &patches {
            for (x, r) in body.x.iter_mut().zip(&sheet.rest) {
                *x = [f[0][0] * r[0] + f[0][1] * r[1], f[1][0] * r[0] + f[1][1] * r[1], 0.0];
            }
            let force = body.forces(&material).unwrap();
            let on_right = sum(&sheet, &force, |x| x[0] > 0.1 - 1e-9);
            let on_top = sum(&sheet, &force, |x| x[1] > 0.1 - 1e-9);
            // In shear the corners of the square also carry a share of the load on the adjacent side.
            if right[1] == 0.0 {
                assert!((on_right[0] - right[0]).abs() < 1e-10, "{pattern:?}: {on_right:?}");
                assert!((on_top[1] - top[1]).abs() < 1e-10, "{pattern:?}: {on_top:?}");
            }
            let inside =
                sheet.rest.iter().zip(&force).filter(|(x, _)| (0..2).all(|i| x[i] > 1e-9 && x[i] < 0.1 - 1e-9));
            let unbalanced = inside.flat_map(|(_, f)| *f).fold(0.0, |m: f64, f| m.max(f.abs()));
            assert!(unbalanced < 1e-10, "{pattern:?}: {unbalanced} N inside");
            // The forces on the sides times the displacement are twice the energy.
            let displaced = |n: usize| [0, 1].map(|i| body.x[n][i] - sheet.rest[n][i]);
            let work: f64 = (0..force.len()).map(|n| (0..2).map(|i| -force[n][i] * displaced(n)[i]).sum::<f64>()).sum();
            let computed = body.energy(&material).unwrap();
            assert!((computed - energy).abs() < 1e-10 * energy.max(1.0), "{pattern:?}: {computed} J");
            assert!((work - 2.0 * computed).abs() < 1e-10, "{pattern:?}: {work} {computed}");
        }
    }
}

#[test]
fn all_strain_measures_agree_to_first_order() {
    for frame in [1.0, 2.0] {
        let material = cloth(&[("frame", frame)]);
        let (sheet, mut body) = square(strip::Pattern::Irregular, &material);
        for (x, r) in body.x.iter_mut().zip(&sheet.rest) {
            *x = [1.0001 * r[0], (1.0 - 3e-5) * r[1], 0.0];
        }
        let energy = body.energy(&material).unwrap();
        assert!((energy / 5e-8 - 1.0).abs() < 1e-3, "{frame}: {energy}");
    }
}

/// A rotation by `angle` (degrees) about an axis, and a translation.
fn moved_rigidly(x: [f64; 3], angle: f64) -> [f64; 3] {
    let axis = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
    let (s, c) = angle.to_radians().sin_cos();
    let along: f64 = (0..3).map(|i| axis[i] * x[i]).sum();
    let cross = [axis[1] * x[2] - axis[2] * x[1], axis[2] * x[0] - axis[0] * x[2], axis[0] * x[1] - axis[1] * x[0]];
    [0, 1, 2].map(|i| c * x[i] + s * cross[i] + (1.0 - c) * along * axis[i] + 0.1)
}

#[test]
fn rigid_motion_has_no_forces() {
    for frame in [0.0, 1.0, 2.0] {
        let material = cloth(&[("frame", frame)]);
        let (sheet, mut body) = square(strip::Pattern::Irregular, &material);
        for angle in [1.0, 45.0, 90.0, 179.0, 360.0] {
            body.x = sheet.rest.iter().map(|x| moved_rigidly(*x, angle)).collect();
            let largest = body.forces(&material).unwrap().into_iter().flatten().fold(0.0, |m: f64, f| m.max(f.abs()));
            assert!(largest < 1e-12 * 1000.0 * 0.1, "{frame} {angle}: {largest}");
        }
    }
}

#[test]
fn viscosity_does_not_resist_rotation_of_a_stretched_sheet() {
    for frame in [0.0, 1.0, 2.0] {
        let material = cloth(&[("frame", frame)]);
        let (sheet, mut body) = square(strip::Pattern::Irregular, &material);
        body.x = sheet.rest.iter().map(|x| [1.3 * x[0] + 0.2 * x[1], x[1], 0.4 * x[0] * x[0] / 0.1]).collect();
        let elastic = body.forces(&material).unwrap();
        let spin = [3.0, -5.0, 7.0];
        body.v = body.x.clone();
        for v in &mut body.v {
            let x = *v;
            *v = [0, 1, 2].map(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                spin[j] * x[k] - spin[k] * x[j] + 1.0
            });
        }
        // The largest viscous force, N.
        let viscous = |forces: &[[f64; 3]]| {
            let all = forces.iter().flatten().zip(elastic.iter().flatten());
            all.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
        };
        let rotating = viscous(&body.forces(&material).unwrap());
        body.v.iter_mut().zip(&sheet.rest).for_each(|(v, x)| *v = [x[0], 0.0, 0.0]);
        let stretching = viscous(&body.forces(&material).unwrap());
        assert!(stretching > 1e-3, "{frame}: {stretching}");
        assert!(rotating < 1e-11 * stretching.max(1.0), "{frame}: {rotating} against {stretching}");
    }
}

/// A trellis: warp and weft rotate towards each other by an angle and keep their length. Each strain is read off the energy of a unit
/// right triangle, by raising the modulus that belongs to it.
#[test]
fn trellis_shear_has_the_strains_of_its_frame() {
    // Frame rule, angle in degrees, strains e11, e22 and gamma in closed form.
    let table = [
        (0.0, 2.0, -1.52304844e-4, -1.52304844e-4, 0.0349048129),
        (0.0, 5.0, -9.51778418e-4, -9.51778418e-4, 0.0872387747),
        (0.0, 8.0, -2.43594974e-3, -2.43594974e-3, 0.139512947),
        (1.0, 2.0, 0.0, -6.09172981e-4, 0.0348994967),
        (1.0, 5.0, 0.0, -3.80530191e-3, 0.0871557427),
        (1.0, 8.0, 0.0, -9.73193126e-3, 0.139173101),
        (2.0, 2.0, 0.0, 0.0, 0.0348994967),
        (2.0, 5.0, 0.0, 0.0, 0.0871557427),
        (2.0, 8.0, 0.0, 0.0, 0.139173101),
    ];
    let sheet = Sheet::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
    for (frame, angle, e11, e22, gamma) in table {
        let energy = |warp: f64, weft: f64, shear: f64| {
            let own =
                [("young-warp", warp), ("young-weft", weft), ("shear", shear), ("poisson", 0.0), ("frame", frame)];
            let material = cloth(&own);
            let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
            let (s, c) = (0.5 * f64::to_radians(angle)).sin_cos();
            body.x = vec![[0.0; 3], [c, s, 0.0], [s, c, 0.0]];
            body.energy(&material).unwrap()
        };
        let base = energy(1.0, 1.0, 1.0);
        let raised = [energy(5.0, 1.0, 1.0), energy(1.0, 5.0, 1.0), energy(1.0, 1.0, 5.0)].map(|e| e - base);
        for (energy, expected) in raised.into_iter().zip([e11, e22, gamma]) {
            // The energy is area * (4 N/m) * strain^2 / 2, and the area is 1/2 m^2.
            let strain = energy.max(0.0).sqrt();
            assert!((strain - f64::abs(expected)).abs() < 1e-9, "{frame} {angle}: {strain} {expected}");
        }
    }
}

#[test]
fn degenerate_triangles_have_finite_forces() {
    // A point, a line, a doubled corner, and triangles that are huge, tiny and thin.
    let states: [[[f64; 3]; 3]; 6] = [
        [[0.0; 3]; 3],
        [[0.0; 3], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]],
        [[0.0; 3], [0.0; 3], [0.0, 0.1, 0.0]],
        [[0.0; 3], [1e6, 0.0, 0.0], [0.0, 1e6, 3e5]],
        [[0.0; 3], [1e-12, 0.0, 0.0], [0.0, 1e-12, 0.0]],
        [[0.0; 3], [0.1, 0.0, 0.0], [0.05, 1e-9, 0.0]],
    ];
    let sheet = Sheet::new(vec![[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]], &[[0, 1, 2]]);
    for (frame, tangent) in [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (0.0, 1.0), (1.0, 1.0), (2.0, 1.0)] {
        let material = cloth(&[("frame", frame), ("tangent", tangent)]);
        for x in states {
            let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
            (body.x, body.v) = (x.to_vec(), vec![[1.0, 2.0, 3.0], [0.0; 3], [-1.0, 0.0, 2.0]]);
            let force = body.forces(&material).unwrap();
            let k = body.tangent(&material, TangentScale { stiffness: 1.0, damping: 1.0 }).unwrap();
            let all_finite = force.iter().flatten().chain(&k).all(|v| v.is_finite());
            assert!(all_finite && body.energy(&material).unwrap().is_finite(), "{frame} {tangent}: {x:?}");
        }
    }
}

#[test]
fn degenerate_triangles_at_rest_are_refused_by_number() {
    let material = cloth(&[]);
    let rest = vec![[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.2, 0.0, 0.0]];
    let open = |triangle: [u32; 3]| {
        let sheet = Sheet::new(rest.clone(), &[[0, 1, 2], triangle]);
        Body::new(&material, rest.clone(), |r| sheet.elements(r.kind)).map(drop)
    };
    assert!(open([1, 2, 0]).is_ok());
    // Without area, and clockwise.
    for triangle in [[0, 1, 3], [0, 2, 1]] {
        let fault = open(triangle).unwrap_err();
        assert!(fault.reason.starts_with("triangle 1 "), "{fault}");
    }
}
