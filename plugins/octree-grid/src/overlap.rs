//! The cells a triangle touches: the separating axis test of triangle and cube, exact except for a slack that only adds cells.
//!
//! The thirteen axes are evaluated as by Schwarz and Seidel (2010): the bounding box of the triangle, its plane, and its edges in the
//! three projections. Along the axis on which the normal is largest, the plane selects a run of two or three cells, so the work is
//! proportional to the area of the triangle. Testing each cell of its bounding box is not: a slanted triangle at level 9 has a box of
//! 17 million cells.

use pliant_plugin_api::lanes::Vec3;

/// Growth of cells in edges, so that rounding never loses one.
const SLACK: f64 = 1e-9;
/// Bound on the rounding error of the plane's equation over the square of the triangle's size.
const PLANE_SLACK: f64 = 1e-12;

/// Calls `touch` with the indices of each cell whose closed cube the triangle meets. `corners` are in units of cells, with `cells` of them
/// along each axis.
pub(crate) fn for_each_touched_cell(corners: &[[f64; 3]; 3], cells: u32, mut touch: impl FnMut([usize; 3])) {
    let [p, q, r] = *corners;
    let last = cells as usize - 1;
    let min = [0, 1, 2].map(|axis| p[axis].min(q[axis]).min(r[axis]));
    let max = [0, 1, 2].map(|axis| p[axis].max(q[axis]).max(r[axis]));
    let low = min.map(|x| ((x - SLACK) as usize).min(last));
    let high = max.map(|x| ((x + SLACK) as usize).min(last));

    // A triangle whose box spans cells along at most one axis meets them all. This is the common case in a fine model.
    if (0..3).filter(|&axis| low[axis] < high[axis]).count() <= 1 {
        for k in low[2]..=high[2] {
            for j in low[1]..=high[1] {
                (low[0]..=high[0]).for_each(|i| touch([i, j, k]));
            }
        }
        return;
    }

    let normal = (Vec3(q) - Vec3(p)).cross(Vec3(r) - Vec3(p)).0;
    let axis = (0..3).fold(0, |best, axis| if normal[axis].abs() > normal[best].abs() { axis } else { best });
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let outlines = [0, 1, 2].map(|axis| Outline::new(corners, axis, normal[axis]));
    let extent = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max);
    let reach = (0.5 + SLACK) * normal.iter().map(|n| n.abs()).sum::<f64>() + PLANE_SLACK * extent * extent;
    for b in low[v]..=high[v] {
        for a in (low[u]..=high[u]).filter(|&a| outlines[axis].meets(a, b)) {
            let (mut first, mut last) = (low[axis], high[axis]);
            if normal[axis] != 0.0 {
                let offset = normal[u] * (a as f64 + 0.5 - p[u]) + normal[v] * (b as f64 + 0.5 - p[v]);
                let (middle, half) = (p[axis] - offset / normal[axis] - 0.5, reach / normal[axis].abs());
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

/// Projection of the triangle along an axis: three half planes `e[0] a + e[1] b + e[2] >= 0` of the cells (a, b) it may touch.
struct Outline([[f64; 3]; 3]);

impl Outline {
    /// `facing` is the component of the normal along the axis.
    fn new(corners: &[[f64; 3]; 3], axis: usize, facing: f64) -> Self {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let side = if facing < 0.0 { -1.0 } else { 1.0 };
        Self([0, 1, 2].map(|i| {
            let (from, to) = (corners[i], corners[(i + 1) % 3]);
            let inward = [side * (from[v] - to[v]), side * (to[u] - from[u])];
            let cell = inward[0].max(0.0) + inward[1].max(0.0) + SLACK * (inward[0].abs() + inward[1].abs());
            [inward[0], inward[1], cell - inward[0] * from[u] - inward[1] * from[v]]
        }))
    }

    /// Whether cell (a, b) is in all half planes.
    fn meets(&self, a: usize, b: usize) -> bool {
        self.0.iter().all(|e| e[0] * a as f64 + e[1] * b as f64 + e[2] >= 0.0)
    }
}
