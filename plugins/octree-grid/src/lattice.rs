//! The cubes of one level: where they are, and what their ids and those of their corners are.
//!
//! Ids are linear, x fastest and z slowest: cell `i + m (j + m k)` of `m` cells per axis, node the same with `m + 1`.
//! Cells and nodes then rise together along x rows, which is how regions are read by the solver. Morton ids were
//! rejected for this reason; the codes of [`Lattice::morton`] only sort the points.

use crate::vector::Vector;
use pliant_plugin_api::Fault;

/// Room around the surface, as a part of its largest extent: points on a max face stay inside their cell.
const PADDING: f64 = 1e-6;
/// The least extent, as a part of the largest coordinate: below it the padding drowns in round-off.
const LEAST_EXTENT: f64 = 1e-9;

/// All cubes of one level, occupied or not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lattice {
    /// 1 is the root.
    pub(crate) level: u32,
    /// Cells per axis.
    pub(crate) cells: u32,
    /// m, of a cell.
    pub(crate) edge: f64,
    /// m, the corner of cell 0 with the least coordinates.
    pub(crate) origin: Vector,
}

impl Lattice {
    /// The root: the cube around `points` (m), with their bounding box in its middle.
    pub(crate) fn root<'a>(points: impl Iterator<Item = &'a Vector>) -> Result<Self, Fault> {
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in points {
            for axis in 0..3 {
                min[axis] = min[axis].min(point[axis]);
                max[axis] = max[axis].max(point[axis]);
            }
        }
        let extent = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max);
        let largest = min.iter().chain(&max).fold(0.0, |a: f64, b| a.max(b.abs()));
        if !(extent > LEAST_EXTENT * largest && extent > 1e-90 && extent < 1e90) {
            let allowed = format!("allowed are 1e-90 to 1e90 m and over {LEAST_EXTENT} of the largest coordinate");
            return Err(Fault::bad_argument(format!("surface is {extent} m across ({largest} m from 0): {allowed}")));
        }
        let edge = extent * (1.0 + 2.0 * PADDING);
        let origin = [0, 1, 2].map(|axis| 0.5 * (min[axis] + max[axis]) - 0.5 * edge);
        Ok(Self { level: 1, cells: 1, edge, origin })
    }

    /// The cubes of another level. Edges differ by powers of two, so all levels agree exactly on the cell of a point.
    pub(crate) fn at(self, level: u32) -> Self {
        let cells = 1 << (level - 1);
        Self { level, cells, edge: self.edge * f64::from(self.cells) / f64::from(cells), origin: self.origin }
    }

    /// Cells in all.
    pub(crate) fn count(&self) -> u64 {
        u64::from(self.cells).pow(3)
    }

    pub(crate) fn id(&self, [i, j, k]: [u32; 3]) -> u64 {
        let m = u64::from(self.cells);
        u64::from(i) + m * (u64::from(j) + m * u64::from(k))
    }

    /// Of an id below [`Lattice::count`].
    pub(crate) fn index(&self, id: u64) -> [u32; 3] {
        let m = u64::from(self.cells);
        [(id % m) as u32, (id / m % m) as u32, (id / m / m) as u32]
    }

    pub(crate) fn node_id(&self, [i, j, k]: [u32; 3]) -> u64 {
        let n = u64::from(self.cells) + 1;
        u64::from(i) + n * (u64::from(j) + n * u64::from(k))
    }

    /// m, the place of a node; of a cell, the corner with the least coordinates.
    pub(crate) fn corner(&self, index: [u32; 3]) -> Vector {
        [0, 1, 2].map(|axis| self.origin[axis] + self.edge * f64::from(index[axis]))
    }

    /// A place (m) counted in cells from the origin.
    pub(crate) fn in_cells(&self, place: Vector) -> Vector {
        [0, 1, 2].map(|axis| (place[axis] - self.origin[axis]) / self.edge)
    }

    /// The cell of a place counted in cells, clamped onto the grid.
    pub(crate) fn cell_of(&self, place: Vector) -> [u32; 3] {
        place.map(|x| (x as u32).min(self.cells - 1))
    }

    /// The bits of `index` interleaved; a coarser level's code is this one without its last three bits.
    pub(crate) fn morton(index: [u32; 3]) -> u32 {
        let spread = |x: u32| (0..10).fold(0, |code, bit| code | (x >> bit & 1) << (3 * bit));
        spread(index[0]) | spread(index[1]) << 1 | spread(index[2]) << 2
    }
}

/// The steps from a cell or node to its neighbours that change so many `axes` and rise in lattice order.
pub(crate) fn steps(axes: usize) -> impl Iterator<Item = [i32; 3]> {
    // 13 in base 3 is no step at all.
    let all = (14..27).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]);
    all.filter(move |step| step.iter().filter(|s| **s != 0).count() == axes)
}
