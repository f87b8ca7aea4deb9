//! The cells a triangle touches, against clipping it by each cube.

use crate::overlap::touched;
use crate::vector::{Vector, add, scale, sub};
use std::collections::BTreeSet;

const CELLS: u32 = 8;

/// Whether something of the triangle is left within a cube grown by `margin`.
fn clips(triangle: [Vector; 3], cube: [usize; 3], margin: f64) -> bool {
    let mut polygon = triangle.to_vec();
    for plane in 0..6 {
        let (axis, sign) = (plane / 2, if plane % 2 == 0 { 1.0 } else { -1.0 });
        let bound = if sign > 0.0 { cube[axis] as f64 - margin } else { cube[axis] as f64 + 1.0 + margin };
        let inside = |p: Vector| sign * (p[axis] - bound);
        let before = std::mem::take(&mut polygon);
        for (i, &p) in before.iter().enumerate() {
            let q = before[(i + 1) % before.len()];
            if inside(p) >= 0.0 {
                polygon.push(p);
            }
            if inside(p) * inside(q) < 0.0 {
                polygon.push(add(p, scale(inside(p) / (inside(p) - inside(q)), sub(q, p))));
            }
        }
    }
    !polygon.is_empty()
}

fn check(triangle: [Vector; 3]) {
    let mut found = BTreeSet::new();
    touched(&triangle, CELLS, |cell| assert!(found.insert(cell), "{cell:?} twice"));
    let m = CELLS as usize;
    for cell in (0..m * m * m).map(|id| [id % m, id / m % m, id / m / m]) {
        let (least, most) = (clips(triangle, cell, -1e-7), clips(triangle, cell, 1e-7));
        assert!(found.contains(&cell) || !least, "{triangle:?} lacks {cell:?}");
        assert!(!found.contains(&cell) || most, "{triangle:?} has {cell:?}");
    }
}

#[test]
fn exactly_the_cells_that_clipping_leaves() {
    let mut seed = 1_u64;
    let mut next = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) as f64 / (1_u64 << 31) as f64
    };
    for round in 0..300 {
        let size = [8.0, 3.0, 0.7][round % 3];
        let base = [0, 1, 2].map(|_| next() * (8.0 - size));
        check([0, 1, 2].map(|_| add(base, [0, 1, 2].map(|_| next() * size))));
        // Nearly a line, nearly along an axis, and exactly in an axis plane.
        let (p, q) = ([0, 1, 2].map(|_| 8.0 * next()), [0, 1, 2].map(|_| 8.0 * next()));
        check([p, q, add(scale(0.3, p), add(scale(0.7, q), scale(1e-9, base)))]);
        check([p, [p[0], p[1], q[2]], [p[0] + 1e-12, p[1], 0.5 * (p[2] + q[2])].map(|x: f64| x.min(8.0))]);
        check([p, [q[0], p[1], q[2]], [base[0], p[1], base[2]]]);
    }
}

#[test]
fn faces_and_points_on_planes_touch_both_sides() {
    let touched = |triangle: [Vector; 3]| {
        let mut found = BTreeSet::new();
        touched(&triangle, CELLS, |cell| assert!(found.insert(cell)));
        found.len()
    };
    assert_eq!(touched([[4.0; 3]; 3]), 8, "a point where eight cells meet");
    assert_eq!(
        touched([[4.0, 4.0, 1.5], [4.0, 4.0, 3.5], [4.0, 4.0, 2.5]]),
        12,
        "a segment on an edge of three cells in a row"
    );
    assert_eq!(touched([[0.5, 0.5, 4.0], [1.5, 0.5, 4.0], [0.5, 1.5, 4.0]]), 8, "two layers of 4, one at its corner");
    assert_eq!(touched([[0.5, 0.5, 4.0], [1.4, 0.5, 4.0], [0.5, 1.4, 4.0]]), 6, "two layers of 3");
    assert_eq!(touched([[8.0; 3]; 3]), 1, "the far corner of the grid");
}
