//! The points of the surface in an order that serves every level: by the Morton code of their finest cell.
//!
//! The points of any cell, of any level, are then one range, found by its code; nothing is stored per cell, and a
//! coarser working level has its points without a second list.

use crate::lattice::Lattice;
use crate::shape::Shape;
use std::ops::Range;

/// Points that triangles use, sorted by cell and within a cell by index.
pub(crate) struct Points {
    finest: u32,
    /// (n) rising
    codes: Vec<u32>,
    /// (n)
    indices: Vec<u32>,
}

impl Points {
    pub(crate) fn new(shape: &Shape<'_>, used: &[bool], lattice: &Lattice) -> Self {
        let used = used.iter().enumerate().filter(|(_, used)| **used).map(|(point, _)| point as u32);
        let code = |point: u32| Lattice::morton(lattice.cell_of(shape.corners[point as usize]));
        let mut sorted: Vec<(u32, u32)> = used.map(|point| (code(point), point)).collect();
        sorted.sort_unstable();
        let (codes, indices) = sorted.into_iter().unzip();
        Self { finest: lattice.level, codes, indices }
    }

    pub(crate) fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// Where the points of a cell stand in [`Points::indices`].
    pub(crate) fn range(&self, level: u32, index: [u32; 3]) -> Range<usize> {
        let (code, shift) = (Lattice::morton(index), 3 * (self.finest - level));
        let start = self.codes.partition_point(|&c| c >> shift < code);
        start..start + self.codes[start..].partition_point(|&c| c >> shift == code)
    }
}
