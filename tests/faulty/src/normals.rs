//! An energy of vertex normals for the sheet of springs: what the sides of a triangle rise along the normals of its corners.

use crate::fault;
use pliant_plugin_api::{Elements, NormalForces};

/// N/m
const STIFFNESS: f64 = 0.3;
const SIDES: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

/// Of each corner's normal and each side of triangle `nodes`: the rise, m, and the side, m. All in space but for a fault.
fn rises(fault: u8, at: &Elements<'_>, normals: &[[f64; 3]], nodes: [u32; 3]) -> [[(f64, [f64; 3]); 3]; 3] {
    nodes.map(|corner| {
        let n = normals[corner as usize];
        SIDES.map(|ends| {
            let [p, q] = ends.map(|end| at.x()[nodes[end] as usize]);
            let side = [0, 1, 2].map(|i| q[i] - p[i]);
            let rise: f64 = (0..3).map(|i| n[i] * side[i]).sum();
            match fault {
                fault::NORMALS_DO_NOT_TURN => (n[2] * side[2], side),
                fault::NORMALS_PULL_AT_REST => (rise - 1e-3, side),
                _ => (rise, side),
            }
        })
    })
}

pub(crate) fn energy(fault: u8, at: &Elements<'_>, normals: &[[f64; 3]]) -> f64 {
    let of =
        |nodes: &[u32; 3]| rises(fault, at, normals, *nodes).as_flattened().iter().map(|(r, _)| r * r).sum::<f64>();
    at.corners::<3>().iter().map(of).sum::<f64>() * 0.5 * STIFFNESS
}

pub(crate) fn forces(fault: u8, at: &Elements<'_>, normals: &[[f64; 3]], out: &mut NormalForces<'_>) {
    if fault == fault::ALLOCATES {
        std::hint::black_box(vec![0_u8; 64]);
    }
    let pull = STIFFNESS * if fault == fault::NORMALS_FORCE_OFF { 1.01 } else { 1.0 };
    // Less, so that what is said of how normals tilt still holds.
    let turn = STIFFNESS * if fault == fault::NORMALS_SLOPE_OFF { 0.99 } else { 1.0 };
    let seen = |v: [f64; 3]| if fault == fault::NORMALS_DO_NOT_TURN { [0.0, 0.0, v[2]] } else { v };
    for &nodes in at.corners::<3>() {
        for (corner, rises) in rises(fault, at, normals, nodes).into_iter().enumerate() {
            let n = seen(normals[nodes[corner] as usize]);
            for ((rise, side), [p, q]) in rises.into_iter().zip(SIDES) {
                out.add(nodes[corner], [0.0; 3], seen(side).map(|c| turn * rise * c));
                out.add(nodes[p], n.map(|c| pull * rise * c), [0.0; 3]);
                out.add(nodes[q], n.map(|c| -pull * rise * c), [0.0; 3]);
            }
        }
    }
}

/// N m, across the sides 01, 12, 20 of triangle `e`: what of its sides is across each.
pub(crate) fn tilt(fault: u8, at: &Elements<'_>, e: usize) -> [f64; 3] {
    let rest = at.corners::<3>()[e].map(|n| at.rest()[n as usize]);
    let side = |a: usize, b: usize| [rest[b][0] - rest[a][0], rest[b][1] - rest[a][1]];
    [0, 1, 2].map(|s| {
        let along = side(s, (s + 1) % 3);
        let length = along[0].hypot(along[1]);
        let across = |v: [f64; 2]| (v[0] * along[1] - v[1] * along[0]) / length;
        let sum: f64 = SIDES.iter().map(|[a, b]| across(side(*a, *b)).powi(2)).sum();
        STIFFNESS * sum * if fault == fault::TILT_TOO_SOFT { 0.5 } else { 1.0 }
    })
}
