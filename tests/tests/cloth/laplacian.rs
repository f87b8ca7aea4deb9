//! The projected Laplacian, bending after Tripicchio, D'Avella and Ruffaldi (2022): R22, and that its force is the slope of its
//! energy, keeps momentum and brakes no turn.

#![allow(clippy::print_stdout, reason = "the table of rigidities")]

use pliant_mesh::generate::Pattern;
use pliant_mesh::testing::Random;
use pliant_solver::{Scheme, Vec3};
use pliant_tests::cloth::{PATTERNS, Piece, cylinder, sheet};
use pliant_tests::solid::forces;

const BENT: &str = "density = 0.2, young-warp = 1000, poisson = 0, shear = 50, damping-time = 0, bending = \"projected-laplacian\", \
    bending-warp = 15e-6";

#[test]
fn r22_rigidity_of_a_cylinder_by_mesh_and_direction() {
    // D over B h^2, by another program, and B h^2 over D: what is made of a rigidity.
    let tabled = [
        (Pattern::Regular, 4.0, [0.249988426, 0.425550303, 0.458288004, 0.249988426]),
        (Pattern::Alternating, 4.0, [0.249988426, 0.281229023, 0.291642555, 0.249988426]),
        (Pattern::Equilateral, 16.0 / 3.0, [0.187491079, 0.18749349, 0.187492284, 0.18749349]),
        (Pattern::Irregular, f64::NAN, [f64::NAN; 4]),
    ];
    for (pattern, given, wanted) in tabled {
        for (degrees, wanted) in [0.0, 30.0, 45.0, 90.0].into_iter().zip(wanted) {
            // The border costs as much as it is wide: half of it at half the width of the cells.
            let at = |radius: f64| {
                let [fine, coarse] = [40, 20].map(|n| cylinder(pattern, n, degrees, "projected-laplacian", radius));
                2.0 * fine - coarse
            };
            let (found, flatter) = (at(0.3), at(0.6));
            let exponent = 2.0 + (found / flatter).log2();
            println!(
                "R22 {pattern:?} {degrees}: {found:.4} D, {:.5} B h^2, reference {wanted:.5}; energy as curvature to {exponent:.4}",
                found / given
            );
            assert!(wanted.is_nan() || (found / given / wanted - 1.0).abs() < 0.01, "{pattern:?} {degrees}: {found}");
            assert!((exponent - 2.0).abs() < 2e-3, "{pattern:?} {degrees}: {exponent}");
            let axis = degrees == 0.0 || degrees == 90.0 || pattern == Pattern::Equilateral;
            let most = if pattern == Pattern::Irregular { 0.1 } else { 0.01 };
            assert!(!axis || (found - 1.0).abs() < most, "{pattern:?} {degrees}: {found}");
        }
    }
}

/// Bent and crumpled: all but what is held moves by up to `share` of a cell.
fn crumple(piece: &mut Piece, share: f64) {
    let mut random = Random(1);
    let held: Vec<bool> = piece.system().nodes.constraint.iter().map(|c| !c.is_free()).collect();
    let mut next = held.into_iter();
    piece.put(|p| {
        let step = 0.025 * share * random.vector();
        let fold = Vec3::new(p[0], p[1], 0.02 * (25.0 * p[0]).sin() * (15.0 * p[1]).cos());
        if next.next() == Some(true) { p } else { fold + step }
    });
}

#[test]
fn force_is_the_slope_of_the_energy_and_keeps_momentum() {
    for pattern in PATTERNS {
        for clamp in [false, true] {
            let held = |p: Vec3| clamp && p[0] < 0.026;
            let of = |bending: &str| {
                let params = BENT.replace("projected-laplacian", bending);
                let mut piece = Piece::new(&sheet(pattern, [8, 8], [0.2, 0.2]), &params, held, clamp);
                crumple(&mut piece, 0.3);
                piece
            };
            let (mut piece, mut bare) = (of("projected-laplacian"), of("none"));
            let bare_of = forces(bare.system());
            let force: Vec<Vec3> = forces(piece.system()).iter().zip(bare_of).map(|(f, m)| *f - m).collect();
            let largest = force.iter().flatten().fold(0.0, |m: f64, f| m.max(f.abs()));
            let mut energy = |node: usize, axis: usize, step: f64| {
                let at = |piece: &mut Piece| {
                    piece.system().nodes.x[node][axis] += step;
                    let energy = piece.energies()[1];
                    piece.system().nodes.x[node][axis] -= step;
                    energy
                };
                at(&mut piece) - at(&mut bare)
            };
            let mut worst = 0.0_f64;
            for node in (0..force.len()).step_by(3) {
                for axis in 0..3 {
                    let slope = (energy(node, axis, 1e-6) - energy(node, axis, -1e-6)) / 2e-6;
                    worst = worst.max((slope + force[node][axis]).abs() / largest);
                }
            }
            let x = &piece.system().nodes.x;
            let sum: Vec3 = force.iter().sum();
            let torque: Vec3 = force.iter().zip(x).map(|(f, x)| x.cross(f)).sum();
            let arm: f64 = force.iter().zip(x).map(|(f, x)| (f.norm_squared() * x.norm_squared()).sqrt()).sum();
            let lost = [sum.norm() / largest, torque.norm() / arm];
            println!(
                "{pattern:?}, clamped {clamp}: slope off by {worst:.1e}, sum {:.1e}, torque {:.1e}",
                lost[0], lost[1]
            );
            assert!(worst > 0.0 && worst < 1e-5, "{pattern:?}: {worst}");
            assert!(lost[0] < 1e-11 && lost[1] < 1e-12, "{pattern:?}: {lost:?}");
        }
    }
}

#[test]
fn r22_a_turn_is_not_braked() {
    // The matrix of the frozen normals brakes it by 2.16 a second.
    for pattern in PATTERNS {
        let mut piece = Piece::new(&sheet(pattern, [31, 31], [0.2, 0.2]), BENT, |_| false, false);
        let centre = Vec3::new(0.1, 0.1, 0.0);
        for axis in [Vec3::x(), Vec3::new(0.6, 0.8, 0.0)] {
            piece.put(|p| p);
            let nodes = &mut piece.system().nodes;
            for i in 0..nodes.len() {
                nodes.v[i] = 0.01 * axis.cross(&(nodes.x[i] - centre));
            }
            let turn = |piece: &mut Piece| {
                let nodes = &piece.system().nodes;
                let all = (0..nodes.len()).map(|i| nodes.mass[i] * axis.dot(&(nodes.x[i] - centre).cross(&nodes.v[i])));
                all.sum::<f64>()
            };
            let before = turn(&mut piece);
            (0..50).for_each(|_| _ = piece.step(1e-3));
            let rate = -(turn(&mut piece) / before).ln() / 0.05;
            println!(
                "R22 turning {pattern:?} about {:?}: braked by {rate:.2e} a second, frozen normals 2.16",
                axis.as_slice()
            );
            assert!(rate.abs() < 1e-5, "{pattern:?}: {rate}");
        }
    }
}

#[test]
fn a_crumpled_sheet_settles_in_large_steps() {
    for scheme in [Scheme::BackwardEuler, Scheme::Bdf2] {
        for pattern in PATTERNS {
            let mut piece =
                Piece::new(&sheet(pattern, [16, 16], [0.05, 0.05]), BENT, |_| false, false).moved_by(scheme);
            let mut random = Random(1);
            piece.put(|p| Vec3::new(p[0], p[1], 1e-5 * random.signed()));
            let first = piece.energies()[1];
            let most = [100, 900].map(|steps| {
                (0..steps).fold(0.0_f64, |most, _| {
                    piece.step(1e-3);
                    most.max(piece.energies()[..2].iter().sum())
                }) / first
            });
            println!("{} {pattern:?}: at most {most:.3?} of the energy it began with", scheme.name());
            assert!(most[0] <= 1.0 && most[1] < 1e-3, "{} {pattern:?}: {most:?}", scheme.name());
        }
    }
}
