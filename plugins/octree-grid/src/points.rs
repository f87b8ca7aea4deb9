//! The surface points, sorted by the Morton code of their cell on the finest level.
//!
//! In this order the points of any cell of any level are one range, which is found by the cell's code. So nothing is stored per cell, and
//! one list serves all levels.

use crate::lattice::Lattice;
use crate::scaled_surface::ScaledSurface;
use std::ops::Range;

/// Points that triangles use, sorted by cell and within a cell by index.
pub(crate) struct Points {
    /// The level of the codes.
    finest: u32,
    /// Code of each point's cell (n), ascending.
    codes: Vec<u32>,
    /// Indices of the points in the surface (n).
    indices: Vec<u32>,
}

impl Points {
    /// Sorts the points that are `used`; `lattice` is that of the finest level.
    pub(crate) fn new(surface: &ScaledSurface<'_>, used: &[bool], lattice: &Lattice) -> Self {
        let used = used.iter().enumerate().filter(|(_, used)| **used).map(|(point, _)| point as u32);
        let code = |point: u32| Lattice::morton(lattice.cell_of(surface.points[point as usize]));
        let mut sorted: Vec<(u32, u32)> = used.map(|point| (code(point), point)).collect();
        sorted.sort_unstable();
        let (codes, indices) = sorted.into_iter().unzip();
        Self { finest: lattice.level, codes, indices }
    }

    /// Indices of the points in the surface, in this order.
    pub(crate) fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// The range of [`Points::indices`] with the points of a cell.
    pub(crate) fn range(&self, level: u32, index: [u32; 3]) -> Range<usize> {
        let (code, shift) = (Lattice::morton(index), 3 * (self.finest - level));
        let start = self.codes.partition_point(|&c| c >> shift < code);
        start..start + self.codes[start..].partition_point(|&c| c >> shift == code)
    }
}
