//! What stands in a matrix for the projected Laplacian, against its stiffness on flat sheets by differences of forces.

#![allow(clippy::print_stdout, reason = "the table of bounds")]

use pliant_solver::{HessianApproximation, Pool, StepTime, SystemScales, Vec3};
use pliant_tests::cloth::{PATTERNS, Piece, sheet};
use pliant_tests::solid::forces;

/// m
const STEP: f64 = 1e-8;

/// A flat sheet with next to nothing in its plane, clamped along x = 0 or free.
fn flat(pattern: pliant_mesh::generate::Pattern, weft: f64, clamp: bool) -> Piece {
    let params = format!(
        "young-warp = 1e-9, poisson = 0, damping-time = 0, bending = \"projected-laplacian\", bending-warp = 15e-6, \
         bending-weft = {weft}"
    );
    Piece::new(&sheet(pattern, [7, 7], [0.07, 0.07]), &params, |p| clamp && p[0] < 1e-9, clamp)
}

/// Out of the plane, N/m, of nodes that are free (n x n): the stiffness, and what stands for it.
fn stiffness(piece: &mut Piece, which: HessianApproximation) -> [Vec<Vec<f64>>; 2] {
    let system = piece.system();
    let free: Vec<usize> = (0..system.nodes.len()).filter(|i| system.nodes.constraint[*i].is_free()).collect();
    let pick = |f: &[Vec3]| free.iter().map(|i| f[*i][2]).collect::<Vec<f64>>();
    let mut exact = Vec::new();
    for &i in &free {
        let mut at = |z: f64| {
            system.nodes.x[i][2] = z;
            pick(&forces(system))
        };
        let (up, down) = (at(STEP), at(-STEP));
        at(0.0);
        exact.push(up.iter().zip(down).map(|(u, d)| (d - u) / (2.0 * STEP)).collect());
    }
    let (pool, mut matrix) = (Pool::new(1), system.matrix.take().unwrap());
    let factors = SystemScales {
        mass: 0.0,
        stiffness: 1.0,
        damping: 0.0,
        hessian: which,
        strains_are_current: false,
        allow_f32: false,
    };
    matrix.assemble(&pool, system.state(StepTime::default()), None, factors).unwrap();
    matrix.add_normals(&pool, system.normals.as_ref().unwrap(), &system.sets, &system.nodes, factors);
    let column = |i: &usize| {
        let (mut unit, mut out) = (vec![Vec3::zeros(); system.nodes.len()], vec![Vec3::zeros(); system.nodes.len()]);
        unit[*i][2] = 1.0;
        matrix.product(&pool, &unit, &mut out);
        pick(&out)
    };
    let stand_in = free.iter().map(column).collect();
    [exact, stand_in]
}

/// Whether `p a - q b` is not negative, to rounding: by Gauss's elimination with a shift.
fn is_at_least(p: f64, a: &[Vec<f64>], q: f64, b: &[Vec<f64>]) -> bool {
    let n = a.len();
    let shift = 1e-6 * (0..n).map(|i| a[i][i]).fold(0.0, f64::max);
    let entry = |i: usize, j: usize| 0.5 * (p * (a[i][j] + a[j][i]) - q * (b[i][j] + b[j][i]));
    let mut m: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
    (0..n).for_each(|i| m[i][i] += shift);
    for k in 0..n {
        if m[k][k] <= 0.0 {
            return false;
        }
        let row = m[k].clone();
        for below in &mut m[k + 1..] {
            let factor = below[k] / row[k];
            below.iter_mut().zip(&row).for_each(|(m, r)| *m -= factor * r);
        }
    }
    true
}

#[test]
fn it_is_nowhere_softer_where_that_is_needed_and_at_least_half_elsewhere() {
    for pattern in PATTERNS {
        for (weft, clamp) in [(15e-6, false), (15e-6, true), (15e-8, false)] {
            let [exact, certain] = stiffness(&mut flat(pattern, weft, clamp), HessianApproximation::UpperBound);
            let [_, half] = stiffness(&mut flat(pattern, weft, clamp), HessianApproximation::AtLeastHalf);
            // The share of it that there is, at least and at most, by bisection.
            let share = |above: bool| {
                let (mut low, mut high) = (0.0, 4.0);
                for _ in 0..20 {
                    let middle = 0.5 * (low + high);
                    let holds = if above {
                        is_at_least(middle, &certain, 1.0, &exact)
                    } else {
                        !is_at_least(1.0, &exact, middle, &certain)
                    };
                    if holds { high = middle } else { low = middle }
                }
                high
            };
            println!("{pattern:?}, weft {weft}, clamped {clamp}: {:.3} to {:.3} of it", share(false), share(true));
            assert!(is_at_least(1.0, &certain, 1.0, &exact), "{pattern:?} {weft} {clamp}: softer than it is");
            assert!(is_at_least(1.0, &half, 0.55, &exact), "{pattern:?} {weft} {clamp}: less than half");
            assert!(is_at_least(1.0, &exact, 0.2, &certain), "{pattern:?} {weft} {clamp}: far too stiff");
        }
    }
}
