//! R15: the drape test of Cusick (1965): a disc of cloth of 30 cm on a disc of 18 cm, and the share of the ring that its shadow
//! covers.

#![allow(clippy::print_stdout, reason = "the table of results")]

use pliant_mesh::Surface;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_tests::cloth::{G, Piece};
use std::f64::consts::PI;

const SPECIMEN: f64 = 0.15;
const DISC: f64 = 0.09;

/// A disc of rings of 6, 12, 18 ... vertices.
fn disc(rings: u32) -> Surface {
    let mut points = vec![Vec3::zeros()];
    let first = |k: u32| if k == 0 { 0 } else { 1 + 3 * k * (k - 1) };
    for k in 1..=rings {
        for i in 0..6 * k {
            let (s, c) = (2.0 * PI * f64::from(i) / f64::from(6 * k)).sin_cos();
            let r = SPECIMEN * f64::from(k) / f64::from(rings);
            points.push(Vec3::new(r * c, r * s, 0.0));
        }
    }
    let mut triangles = Vec::new();
    for k in 1..=rings {
        for sector in 0..6 {
            for i in 0..k {
                let outer = |i: u32| first(k) + (sector * k + i) % (6 * k);
                let inner = |i: u32| if k == 1 { 0 } else { first(k - 1) + (sector * (k - 1) + i) % (6 * (k - 1)) };
                triangles.push([inner(i), outer(i), outer(i + 1)]);
                if i + 1 < k {
                    triangles.push([inner(i), outer(i + 1), inner(i + 1)]);
                }
            }
        }
    }
    Surface { points, triangles, ..Surface::default() }
}

/// m^2, of the shadow from above, to 1 mm.
fn shadow(piece: &mut Piece, triangles: &[[u32; 3]]) -> f64 {
    let (n, h) = (400_usize, 1e-3);
    let mut covered = vec![false; n * n];
    let x = &piece.system().nodes.x;
    for t in triangles {
        let [a, b, c] = t.map(|v| [x[v as usize][0], x[v as usize][1]]);
        let cell = |value: f64| ((value / h) + 0.5 * n as f64).clamp(0.0, n as f64 - 1.0) as usize;
        let range = |i: usize| cell(a[i].min(b[i]).min(c[i]))..=cell(a[i].max(b[i]).max(c[i]));
        let turn =
            |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        for j in range(1) {
            for i in range(0) {
                let p = [i, j].map(|k| (k as f64 + 0.5 - 0.5 * n as f64) * h);
                let sides = [turn(a, b, p), turn(b, c, p), turn(c, a, p)];
                covered[j * n + i] |= sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
            }
        }
    }
    covered.iter().filter(|c| **c).count() as f64 * h * h
}

/// Drape coefficient and number of folds of a fabric with a bending length (m).
fn drape(bending_length: f64) -> (f64, usize) {
    let rho = 0.2;
    let rigidity = rho * G * bending_length.powi(3);
    let params =
        format!("density = {rho}, young-warp = 500, poisson = 0.3, bending-warp = {rigidity:e}, damping-time = 0.03");
    let surface = disc(15);
    let mut piece = Piece::new(&surface, &params, |p| p[0].hypot(p[1]) < DISC + 1e-9, false);
    piece.integrator = pliant_solver::Integrator::new(pliant_solver::Scheme::BackwardEuler, 1e-4, 2000);
    piece.integrator.resize(surface.points.len());
    piece.gravity = Vec3::new(0.0, 0.0, -G);
    let mut random = Random(1);
    let nodes = &mut piece.system().nodes;
    (0..nodes.len()).filter(|i| nodes.constraint[*i].is_free()).for_each(|i| nodes.x[i][2] = 1e-3 * random.signed());
    (0..300).for_each(|_| _ = piece.step(5e-3));
    let area = shadow(&mut piece, &surface.triangles);
    let x = &piece.system().nodes.x;
    let edge: Vec<f64> = x[x.len() - 90..].iter().map(|p| p[0].hypot(p[1])).collect();
    let smooth: Vec<f64> = (0..90).map(|i| (0..5).map(|k| edge[(i + k) % 90]).sum::<f64>() / 5.0).collect();
    let mean = smooth.iter().sum::<f64>() / 90.0;
    let folds = (0..90).filter(|i| (smooth[*i] > mean) && (smooth[(i + 1) % 90] <= mean)).count();
    ((area - PI * DISC * DISC) / (PI * (SPECIMEN * SPECIMEN - DISC * DISC)), folds)
}

#[test]
fn r15_drape() {
    let lengths = [0.3, 0.04, 0.025, 0.015, 0.008];
    let found = lengths.map(drape);
    println!("R15 bending lengths {lengths:?} m: drape coefficient and folds {found:.3?}");
    assert!((found[0].0 - 1.0).abs() < 0.05, "a board stays flat: {found:?}");
    assert!(found.windows(2).all(|pair| pair[1].0 < pair[0].0), "the limper, the less: {found:?}");
    assert!((-0.05..0.5).contains(&found[4].0), "limp: {found:?}");
    assert!(found[2..].iter().all(|(_, folds)| (4..=10).contains(folds)), "folds: {found:?}");
}
