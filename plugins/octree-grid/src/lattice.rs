//! The cubes of one level: their positions, and the ids of cells and nodes.
//!
//! Ids are linear, x fastest and z slowest: a cell has the id `i + m (j + m k)` with m cells per axis, a node the same with m + 1. So the
//! ids of cells and nodes ascend along rows of x, in the order in which the solver reads a region. Morton ids do not; the codes of
//! [`Lattice::morton`] only sort the surface points.

use pliant_plugin_api::Fault;

/// Padding around the surface over its largest extent, so that points on the greatest faces lie inside their cells.
const PADDING: f64 = 1e-6;
/// Least extent over the largest coordinate: with less, the padding is smaller than the rounding of coordinates.
const MIN_EXTENT: f64 = 1e-9;

/// All cubes of one level, occupied or not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lattice {
    /// Level of the octree; 1 is the root.
    pub(crate) level: u32,
    /// Cells per axis.
    pub(crate) cells: u32,
    /// Length of a cell's edge, m.
    pub(crate) edge: f64,
    /// Corner of cell 0 with the least coordinates, m.
    pub(crate) origin: [f64; 3],
}

impl Lattice {
    /// The root: the cube around the bounding box of `points` (m), with the same centre.
    ///
    /// # Errors
    /// Points without extent, or with an extent outside the range of numbers that can be computed with.
    pub(crate) fn root<'a>(points: impl Iterator<Item = &'a [f64; 3]>) -> Result<Self, Fault> {
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in points {
            for axis in 0..3 {
                min[axis] = min[axis].min(point[axis]);
                max[axis] = max[axis].max(point[axis]);
            }
        }
        let extent = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max);
        let largest = min.iter().chain(&max).fold(0.0, |a: f64, b| a.max(b.abs()));
        if !(extent > MIN_EXTENT * largest && extent > 1e-90 && extent < 1e90) {
            let allowed = format!("allowed are 1e-90 to 1e90 m and over {MIN_EXTENT} of the largest coordinate");
            return Err(Fault::bad_argument(format!("surface is {extent} m across ({largest} m from 0): {allowed}")));
        }
        let edge = extent * (1.0 + 2.0 * PADDING);
        let origin = [0, 1, 2].map(|axis| 0.5 * (min[axis] + max[axis]) - 0.5 * edge);
        Ok(Self { level: 1, cells: 1, edge, origin })
    }

    /// The cubes of another level. Edges differ by powers of two, so a point's cells on all levels are exactly nested.
    pub(crate) fn at_level(self, level: u32) -> Self {
        let cells = 1 << (level - 1);
        Self { level, cells, edge: self.edge * f64::from(self.cells) / f64::from(cells), origin: self.origin }
    }

    /// Number of cells.
    pub(crate) fn count(&self) -> u64 {
        u64::from(self.cells).pow(3)
    }

    /// Id of a cell from its indices.
    pub(crate) fn id(&self, [i, j, k]: [u32; 3]) -> u64 {
        let m = u64::from(self.cells);
        u64::from(i) + m * (u64::from(j) + m * u64::from(k))
    }

    /// Indices of a cell from its id, which is below [`Lattice::count`].
    pub(crate) fn index(&self, id: u64) -> [u32; 3] {
        let m = u64::from(self.cells);
        [(id % m) as u32, (id / m % m) as u32, (id / m / m) as u32]
    }

    /// Id of a node from its indices.
    pub(crate) fn node_id(&self, [i, j, k]: [u32; 3]) -> u64 {
        let n = u64::from(self.cells) + 1;
        u64::from(i) + n * (u64::from(j) + n * u64::from(k))
    }

    /// Position of a node, m; for a cell's indices, its corner with the least coordinates.
    pub(crate) fn corner(&self, index: [u32; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.origin[axis] + self.edge * f64::from(index[axis]))
    }

    /// A position (m) in units of cells from the origin.
    pub(crate) fn in_cells(&self, position: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| (position[axis] - self.origin[axis]) / self.edge)
    }

    /// Indices of the cell that contains a position in units of cells, clamped to the grid.
    pub(crate) fn cell_of(&self, scaled: [f64; 3]) -> [u32; 3] {
        scaled.map(|x| (x as u32).min(self.cells - 1))
    }

    /// Morton code: the bits of the three indices interleaved. The code of the parent is this one without its last three bits.
    pub(crate) fn morton(index: [u32; 3]) -> u32 {
        let spread = |x: u32| (0..10).fold(0, |code, bit| code | (x >> bit & 1) << (3 * bit));
        spread(index[0]) | spread(index[1]) << 1 | spread(index[2]) << 2
    }
}

/// The steps from a cell or node to those neighbours that differ along exactly `axes` axes and have a greater id.
pub(crate) fn steps(axes: usize) -> impl Iterator<Item = [i32; 3]> {
    // In base 3, 13 is the step 0 and larger numbers are the steps to greater ids.
    let all = (14..27).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]);
    all.filter(move |step| step.iter().filter(|s| **s != 0).count() == axes)
}
