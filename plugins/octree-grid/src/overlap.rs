//! Which cells a triangle touches: the separating axis test of triangle and cube, exact but for a slack that only adds.
//!
//! The thirteen axes are taken as Schwarz and Seidel (2010) do: the cell box of the triangle, its plane, and its
//! outline in the three projections. Along the axis on which the normal is largest the plane leaves a run of two or
//! three cells, so the work grows with the area of the triangle and not with its box. The plain test of each cell in
//! the box was rejected: one slanted triangle at level 9 has a box of 17 million cells.

use crate::vector::{Vector, cross, sub};

/// Cells are grown by this part of an edge, so that round-off never loses one.
const SLACK: f64 = 1e-9;
/// Bound on the round-off of a plane, relative to the square of the triangle's size.
const PLANE_SLACK: f64 = 1e-12;

/// Calls `touch` with the index of each cell whose closed cube the triangle meets; corners are counted in cells.
pub(crate) fn touched(corners: &[Vector; 3], cells: u32, mut touch: impl FnMut([usize; 3])) {
    let [p, q, r] = *corners;
    let last = cells as usize - 1;
    let min = [0, 1, 2].map(|axis| p[axis].min(q[axis]).min(r[axis]));
    let max = [0, 1, 2].map(|axis| p[axis].max(q[axis]).max(r[axis]));
    let low = min.map(|x| ((x - SLACK) as usize).min(last));
    let high = max.map(|x| ((x + SLACK) as usize).min(last));

    // A triangle that spans cells along one axis at most meets them all: most triangles of a fine model end here.
    if (0..3).filter(|&axis| low[axis] < high[axis]).count() <= 1 {
        for k in low[2]..=high[2] {
            for j in low[1]..=high[1] {
                (low[0]..=high[0]).for_each(|i| touch([i, j, k]));
            }
        }
        return;
    }

    let normal = cross(sub(q, p), sub(r, p));
    let axis = (0..3).fold(0, |best, axis| if normal[axis].abs() > normal[best].abs() { axis } else { best });
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let outlines = [0, 1, 2].map(|axis| Outline::new(corners, axis, normal[axis]));
    let extent = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max);
    let reach = (0.5 + SLACK) * normal.iter().map(|n| n.abs()).sum::<f64>() + PLANE_SLACK * extent * extent;
    for b in low[v]..=high[v] {
        for a in (low[u]..=high[u]).filter(|&a| outlines[axis].meets(a, b)) {
            let (mut first, mut last) = (low[axis], high[axis]);
            if normal[axis] != 0.0 {
                let slope = normal[u] * (a as f64 + 0.5 - p[u]) + normal[v] * (b as f64 + 0.5 - p[v]);
                let (middle, half) = (p[axis] - slope / normal[axis] - 0.5, reach / normal[axis].abs());
                first = first.max((middle - half).ceil() as usize);
                last = last.min((middle + half).floor() as usize);
            }
            for c in (first..=last).filter(|&c| outlines[u].meets(b, c) && outlines[v].meets(c, a)) {
                let mut index = [0; 3];
                (index[axis], index[u], index[v]) = (c, a, b);
                touch(index);
            }
        }
    }
}

/// The triangle seen along an axis: three half planes `e[0] a + e[1] b + e[2] >= 0` of the cells (a, b) in reach.
struct Outline([[f64; 3]; 3]);

impl Outline {
    fn new(corners: &[Vector; 3], axis: usize, facing: f64) -> Self {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let side = if facing < 0.0 { -1.0 } else { 1.0 };
        Self([0, 1, 2].map(|i| {
            let (from, to) = (corners[i], corners[(i + 1) % 3]);
            let inward = [side * (from[v] - to[v]), side * (to[u] - from[u])];
            let cell = inward[0].max(0.0) + inward[1].max(0.0) + SLACK * (inward[0].abs() + inward[1].abs());
            [inward[0], inward[1], cell - inward[0] * from[u] - inward[1] * from[v]]
        }))
    }

    fn meets(&self, a: usize, b: usize) -> bool {
        self.0.iter().all(|e| e[0] * a as f64 + e[1] * b as f64 + e[2] >= 0.0)
    }
}
