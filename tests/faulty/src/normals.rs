//! An energy of vertex normals for the sheet of springs: the squares of the sides' components along the normals of the corners.

use crate::fault;
use pliant_plugin_api::{Elements, NormalForces};

/// Stiffness against such a component, N/m.
const STIFFNESS: f64 = 0.3;
/// Corners at the ends of each side.
const SIDES: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

/// For each corner of the triangle `nodes` and each side: the side's component along the corner's normal, m, and the side, m.
fn rises(fault: u8, elements: &Elements<'_>, normals: &[[f64; 3]], nodes: [u32; 3]) -> [[(f64, [f64; 3]); 3]; 3] {
    nodes.map(|corner| {
        let n = normals[corner as usize];
        SIDES.map(|ends| {
            let [p, q] = ends.map(|end| elements.x()[nodes[end] as usize]);
            let side = [0, 1, 2].map(|i| q[i] - p[i]);
            let rise: f64 = (0..3).map(|i| n[i] * side[i]).sum();
            match fault {
                fault::NORMALS_NOT_OBJECTIVE => (n[2] * side[2], side),
                fault::NORMALS_PULL_AT_REST => (rise - 1e-3, side),
                _ => (rise, side),
            }
        })
    })
}

/// J
pub(crate) fn energy(fault: u8, elements: &Elements<'_>, normals: &[[f64; 3]]) -> f64 {
    let of = |nodes: &[u32; 3]| {
        rises(fault, elements, normals, *nodes).as_flattened().iter().map(|(r, _)| r * r).sum::<f64>()
    };
    elements.corners::<3>().iter().map(of).sum::<f64>() * 0.5 * STIFFNESS
}

/// Adds forces and derivatives by the normals.
pub(crate) fn forces(fault: u8, elements: &Elements<'_>, normals: &[[f64; 3]], out: &mut NormalForces<'_>) {
    if fault == fault::ALLOCATES {
        std::hint::black_box(vec![0_u8; 64]);
    }
    let pull = STIFFNESS * if fault == fault::NORMALS_FORCE_OFF { 1.01 } else { 1.0 };
    // A factor below 1, so that `tilt` is still an upper bound.
    let turn = STIFFNESS * if fault == fault::NORMALS_DERIVATIVE_OFF { 0.99 } else { 1.0 };
    let projected = |v: [f64; 3]| if fault == fault::NORMALS_NOT_OBJECTIVE { [0.0, 0.0, v[2]] } else { v };
    for &nodes in elements.corners::<3>() {
        for (corner, rises) in rises(fault, elements, normals, nodes).into_iter().enumerate() {
            let n = projected(normals[nodes[corner] as usize]);
            for ((rise, side), [p, q]) in rises.into_iter().zip(SIDES) {
                out.add(nodes[corner], [0.0; 3], projected(side).map(|c| turn * rise * c));
                out.add(nodes[p], n.map(|c| pull * rise * c), [0.0; 3]);
                out.add(nodes[q], n.map(|c| -pull * rise * c), [0.0; 3]);
            }
        }
    }
}

/// Stiffness against tilting across the sides 01, 12, 20 of triangle `e`, N m: from the squares of the sides' components across each.
pub(crate) fn tilt(fault: u8, elements: &Elements<'_>, e: usize) -> [f64; 3] {
    let rest = elements.corners::<3>()[e].map(|n| elements.rest()[n as usize]);
    let side = |a: usize, b: usize| [rest[b][0] - rest[a][0], rest[b][1] - rest[a][1]];
    [0, 1, 2].map(|s| {
        let along = side(s, (s + 1) % 3);
        let length = along[0].hypot(along[1]);
        let across = |v: [f64; 2]| (v[0] * along[1] - v[1] * along[0]) / length;
        let sum: f64 = SIDES.iter().map(|[a, b]| across(side(*a, *b)).powi(2)).sum();
        STIFFNESS * sum * if fault == fault::TILT_TOO_SOFT { 0.5 } else { 1.0 }
    })
}
