//! The cells a triangle touches, against clipping it at each cube.

use crate::overlap::for_each_touched_cell;
use pliant_plugin_api::kit::Random;
use pliant_plugin_api::lanes::Vec3;
use std::collections::BTreeSet;

const CELLS: u32 = 8;

/// Whether clipping the triangle at a cube grown by `margin` leaves a polygon.
fn clips(triangle: [[f64; 3]; 3], cube: [usize; 3], margin: f64) -> bool {
    let mut polygon = triangle.to_vec();
    for plane in 0..6 {
        let (axis, sign) = (plane / 2, if plane % 2 == 0 { 1.0 } else { -1.0 });
        let bound = if sign > 0.0 { cube[axis] as f64 - margin } else { cube[axis] as f64 + 1.0 + margin };
        let inside = |p: [f64; 3]| sign * (p[axis] - bound);
        let before = std::mem::take(&mut polygon);
        for (i, &p) in before.iter().enumerate() {
            let q = before[(i + 1) % before.len()];
            if inside(p) >= 0.0 {
                polygon.push(p);
            }
            if inside(p) * inside(q) < 0.0 {
                polygon.push((Vec3(p) + (Vec3(q) - Vec3(p)) * (inside(p) / (inside(p) - inside(q)))).0);
            }
        }
    }
    !polygon.is_empty()
}

/// Compares the cells with clipping, to a margin of 1e-7.
fn check(triangle: [[f64; 3]; 3]) {
    let mut found = BTreeSet::new();
    for_each_touched_cell(&triangle, CELLS, |cell| assert!(found.insert(cell), "{cell:?} twice"));
    let m = CELLS as usize;
    for cell in (0..m * m * m).map(|id| [id % m, id / m % m, id / m / m]) {
        let (shrunk, grown) = (clips(triangle, cell, -1e-7), clips(triangle, cell, 1e-7));
        assert!(found.contains(&cell) || !shrunk, "{triangle:?} lacks {cell:?}");
        assert!(!found.contains(&cell) || grown, "{triangle:?} has {cell:?}");
    }
}

#[test]
fn touched_cells_are_those_of_clipping() {
    let mut random = Random(1);
    for round in 0..300 {
        let size = [8.0, 3.0, 0.7][round % 3];
        let base = Vec3([0, 1, 2].map(|_| random.unit() * (8.0 - size)));
        check([0, 1, 2].map(|_| (base + Vec3([0, 1, 2].map(|_| random.unit() * size))).0));
        // Nearly collinear, nearly along an axis, and in a plane of two axes.
        let (p, q) = ([0, 1, 2].map(|_| 8.0 * random.unit()), [0, 1, 2].map(|_| 8.0 * random.unit()));
        check([p, q, (Vec3(p) * 0.3 + (Vec3(q) * 0.7 + base * 1e-9)).0]);
        check([p, [p[0], p[1], q[2]], [p[0] + 1e-12, p[1], 0.5 * (p[2] + q[2])].map(|x: f64| x.min(8.0))]);
        check([p, [q[0], p[1], q[2]], [base[0], p[1], base[2]]]);
    }
}

#[test]
fn faces_and_points_on_planes_touch_both_sides() {
    let count = |triangle: [[f64; 3]; 3]| {
        let mut found = BTreeSet::new();
        for_each_touched_cell(&triangle, CELLS, |cell| assert!(found.insert(cell)));
        found.len()
    };
    assert_eq!(count([[4.0; 3]; 3]), 8, "a point where eight cells meet");
    assert_eq!(
        count([[4.0, 4.0, 1.5], [4.0, 4.0, 3.5], [4.0, 4.0, 2.5]]),
        12,
        "a segment on an edge of three cells in a row"
    );
    assert_eq!(count([[0.5, 0.5, 4.0], [1.5, 0.5, 4.0], [0.5, 1.5, 4.0]]), 8, "two layers of 4, one at its corner");
    assert_eq!(count([[0.5, 0.5, 4.0], [1.4, 0.5, 4.0], [0.5, 1.4, 4.0]]), 6, "two layers of 3");
    assert_eq!(count([[8.0; 3]; 3]), 1, "the far corner of the grid");
}
