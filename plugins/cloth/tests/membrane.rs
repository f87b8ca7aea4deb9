//! What a sheet does in its plane: patches, rigid motion, shear of a trellis, and states nobody should see.

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

fn cloth(more: &[(&str, f64)]) -> Cloth {
    kit::material(&[&SHEET[..], more].concat()).unwrap()
}

/// A square of 0.1 m, and a body of it.
fn square(pattern: strip::Pattern, material: &Cloth) -> (Sheet, Body) {
    let mut sheet = strip(pattern, 8);
    let wide = sheet.rest.iter().fold(0.0, |m: f64, x| m.max(x[1]));
    assert!((wide / WIDTH - 1.0).abs() < 0.2);
    sheet.rest.iter_mut().for_each(|x| *x = [0.1 * x[0], 0.1 * x[1] / wide, 0.0]);
    let triangles: Vec<[u32; 3]> = sheet.triangles.nodes.as_chunks::<3>().0.to_vec();
    let sheet = Sheet::new(sheet.rest, &triangles);
    let body = Body::new(material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    (sheet, body)
}

/// The sum of forces on nodes that `chosen` takes, N.
fn sum(sheet: &Sheet, force: &[[f64; 3]], chosen: impl Fn([f64; 3]) -> bool) -> [f64; 3] {
    let taken = sheet.rest.iter().zip(force).filter(|(x, _)| chosen(**x)).map(|(_, f)| *f);
    taken.fold([0.0; 3], |s, f| [s[0] + f[0], s[1] + f[1], s[2] + f[2]])
}

#[test]
fn patches_are_exact() {
    let material = cloth(&[]);
    // F by rows, forces on the sides x = 0.1 and y = 0.1 in N, energy in J.
    let patches = [
        ([[1.01, 0.0], [0.0, 0.997]], [-1.0, 0.0], [0.0, 0.0], 5e-4),
        ([[0.9985, 0.0], [0.0, 1.01]], [0.0, 0.0], [0.0, -0.5], 2.5e-4),
        ([[1.0, 0.01], [0.01, 1.0]], [0.0, -0.1], [-0.1, 0.0], 1e-4),
    ];
    for pattern in PATTERNS {
        let (sheet, mut body) = square(pattern, &material);
        for (f, right, top, energy) in patches {
            for (x, r) in body.x.iter_mut().zip(&sheet.rest) {
                *x = [f[0][0] * r[0] + f[0][1] * r[1], f[1][0] * r[0] + f[1][1] * r[1], 0.0];
            }
            let force = body.forces(&material).unwrap();
            let on_right = sum(&sheet, &force, |x| x[0] > 0.1 - 1e-9);
            let on_top = sum(&sheet, &force, |x| x[1] > 0.1 - 1e-9);
            // In shear the end nodes of a side carry half an edge of the next side's load too.
            if right[1] == 0.0 {
                assert!((on_right[0] - right[0]).abs() < 1e-10, "{pattern:?}: {on_right:?}");
                assert!((on_top[1] - top[1]).abs() < 1e-10, "{pattern:?}: {on_top:?}");
            }
            let inside =
                sheet.rest.iter().zip(&force).filter(|(x, _)| (0..2).all(|i| x[i] > 1e-9 && x[i] < 0.1 - 1e-9));
            let left = inside.flat_map(|(_, f)| *f).fold(0.0, |m: f64, f| m.max(f.abs()));
            assert!(left < 1e-10, "{pattern:?}: {left} N inside");
            // Work of the sides on the displacement is twice the energy.
            let displaced = |n: usize| [0, 1].map(|i| body.x[n][i] - sheet.rest[n][i]);
            let work: f64 = (0..force.len()).map(|n| (0..2).map(|i| -force[n][i] * displaced(n)[i]).sum::<f64>()).sum();
            let found = body.energy(&material).unwrap();
            assert!((found - energy).abs() < 1e-10 * energy.max(1.0), "{pattern:?}: {found} J");
            assert!((work - 2.0 * found).abs() < 1e-10, "{pattern:?}: {work} {found}");
        }
    }
}

#[test]
fn other_strains_agree_with_the_patch_to_first_order() {
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

/// A turn by `angle` about an axis, and a shift.
fn turned(x: [f64; 3], angle: f64) -> [f64; 3] {
    let axis = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
    let (s, c) = angle.to_radians().sin_cos();
    let along: f64 = (0..3).map(|i| axis[i] * x[i]).sum();
    let cross = [axis[1] * x[2] - axis[2] * x[1], axis[2] * x[0] - axis[0] * x[2], axis[0] * x[1] - axis[1] * x[0]];
    [0, 1, 2].map(|i| c * x[i] + s * cross[i] + (1.0 - c) * along * axis[i] + 0.1)
}

#[test]
fn rigid_motion_is_free() {
    for frame in [0.0, 1.0, 2.0] {
        let material = cloth(&[("frame", frame)]);
        let (sheet, mut body) = square(strip::Pattern::Irregular, &material);
        for angle in [1.0, 45.0, 90.0, 179.0, 360.0] {
            body.x = sheet.rest.iter().map(|x| turned(*x, angle)).collect();
            let most = body.forces(&material).unwrap().into_iter().flatten().fold(0.0, |m: f64, f| m.max(f.abs()));
            assert!(most < 1e-12 * 1000.0 * 0.1, "{frame} {angle}: {most}");
        }
    }
}

#[test]
fn viscosity_does_not_brake_a_turning_sheet_however_stretched() {
    for frame in [0.0, 1.0, 2.0] {
        let material = cloth(&[("frame", frame)]);
        let (sheet, mut body) = square(strip::Pattern::Irregular, &material);
        body.x = sheet.rest.iter().map(|x| [1.3 * x[0] + 0.2 * x[1], x[1], 0.4 * x[0] * x[0] / 0.1]).collect();
        let still = body.forces(&material).unwrap();
        let spin = [3.0, -5.0, 7.0];
        body.v = body.x.clone();
        for v in &mut body.v {
            let x = *v;
            *v = [0, 1, 2].map(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                spin[j] * x[k] - spin[k] * x[j] + 1.0
            });
        }
        let apart = |with: &[[f64; 3]]| {
            let all = with.iter().flatten().zip(still.iter().flatten());
            all.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
        };
        let turning = apart(&body.forces(&material).unwrap());
        body.v.iter_mut().zip(&sheet.rest).for_each(|(v, x)| *v = [x[0], 0.0, 0.0]);
        let stretching = apart(&body.forces(&material).unwrap());
        assert!(stretching > 1e-3, "{frame}: {stretching}");
        assert!(turning < 1e-11 * stretching.max(1.0), "{frame}: {turning} against {stretching}");
    }
}

/// Stress times area over stiffness is the strain of one element: by the force on a corner of a unit right triangle.
#[test]
fn trellis_shear_stretches_yarns_as_tabled() {
    // Warp and weft turn towards each other by gamma: true strain of the yarns 0 (degrees, e11, e22, gamma).
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
    for (frame, gamma, e11, e22, shear) in table {
        // The energy with two stiffnesses tells the strains apart.
        let energy = |warp: f64, weft: f64, of_shear: f64| {
            let own =
                [("young-warp", warp), ("young-weft", weft), ("shear", of_shear), ("poisson", 0.0), ("frame", frame)];
            let material = cloth(&own);
            let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
            let (s, c) = (0.5 * f64::to_radians(gamma)).sin_cos();
            body.x = vec![[0.0; 3], [c, s, 0.0], [s, c, 0.0]];
            body.energy(&material).unwrap()
        };
        let base = energy(1.0, 1.0, 1.0);
        let found = [energy(5.0, 1.0, 1.0), energy(1.0, 5.0, 1.0), energy(1.0, 1.0, 5.0)].map(|e| e - base);
        for (found, want) in found.into_iter().zip([e11, e22, shear]) {
            // area / 2 * 4 N/m * strain^2
            let strain = found.max(0.0).sqrt();
            assert!((strain - f64::abs(want)).abs() < 1e-9, "{frame} {gamma}: {strain} {want}");
        }
    }
}

#[test]
fn states_nobody_should_see_stay_finite() {
    let places: [[[f64; 3]; 3]; 6] = [
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
        for x in places {
            let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
            (body.x, body.v) = (x.to_vec(), vec![[1.0, 2.0, 3.0], [0.0; 3], [-1.0, 0.0, 2.0]]);
            let force = body.forces(&material).unwrap();
            let k = body.tangent(&material, TangentScale { stiffness: 1.0, damping: 1.0 }).unwrap();
            let finite = force.iter().flatten().chain(&k).all(|v| v.is_finite());
            assert!(finite && body.energy(&material).unwrap().is_finite(), "{frame} {tangent}: {x:?}");
        }
    }
}

#[test]
fn unusable_triangles_are_refused_by_number() {
    let material = cloth(&[]);
    let rest = vec![[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.2, 0.0, 0.0]];
    for bad in [[1, 2, 0], [0, 1, 3], [0, 2, 1]] {
        let sheet = Sheet::new(rest.clone(), &[[0, 1, 2], bad]);
        let found = Body::new(&material, rest.clone(), |r| sheet.elements(r.kind));
        if bad == [1, 2, 0] {
            assert!(found.is_ok());
        } else {
            let fault = found.map(drop).unwrap_err();
            assert!(fault.reason.starts_with("triangle 1 "), "{fault}");
        }
    }
}
