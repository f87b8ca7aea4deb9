//! The pattern of a matrix: where the blocks of its rows are stored, and sums over the blocks of a row.

use crate::algebra::{Block, SingleBlock};
use crate::lanes::Entry;

/// A block below the diagonal. Its transpose is stored, above the diagonal.
#[derive(Clone, Copy, Debug)]
pub struct LowerBlock {
    /// Column of the block.
    pub column: u32,
    /// Slot of its transpose.
    pub slot: u32,
}

/// A stored block above the diagonal.
#[derive(Clone, Copy, Debug)]
pub struct UpperBlock {
    /// Row of the block.
    pub row: u32,
    /// Column of the block, greater than the row.
    pub column: u32,
    /// Index of its block among the blocks of the matrix.
    pub slot: u32,
}

/// The pattern of a matrix of n rows.
#[derive(Clone, Copy)]
pub struct Pattern<'a> {
    /// Slot of the diagonal block of each row, and the number of slots (n + 1).
    pub row: &'a [usize],
    /// Column of the block in each slot, ascending within a row.
    pub column: &'a [u32],
    /// Where the blocks of each row begin in `lower` (n + 1).
    pub lower_row: &'a [usize],
    /// Blocks below the diagonal, row by row.
    pub lower: &'a [LowerBlock],
}

/// The blocks of one row off the diagonal.
#[derive(Clone, Copy)]
pub struct OffDiagonal<'a> {
    /// Blocks below the diagonal.
    pub lower: &'a [LowerBlock],
    /// Slot of the first block above the diagonal; the others of the row follow.
    pub first_slot: usize,
    /// Columns of the blocks above the diagonal, ascending.
    pub columns: &'a [u32],
}

impl<'a> Pattern<'a> {
    /// Number of rows.
    pub fn count(&self) -> usize {
        self.row.len() - 1
    }

    /// The blocks of row i off the diagonal.
    #[inline(always)]
    pub fn off_diagonal(&self, i: usize) -> OffDiagonal<'a> {
        let upper = self.row[i] + 1..self.row[i + 1];
        let lower = &self.lower[self.lower_row[i]..self.lower_row[i + 1]];
        OffDiagonal { lower, first_slot: upper.start, columns: &self.column[upper] }
    }
}

/// Sum of all blocks of a row.
#[inline(always)]
pub fn row_sum(pattern: Pattern<'_>, blocks: &[Block], row: usize) -> Block {
    sum(pattern, blocks, row, pattern.row[row])
}

/// Sum of the blocks of a row off the diagonal.
#[inline(always)]
pub fn off_diagonal_sum(pattern: Pattern<'_>, blocks: &[SingleBlock], row: usize) -> Block {
    sum(pattern, blocks, row, pattern.row[row] + 1)
}

/// Sum of the blocks of a row below the diagonal and of its stored blocks from slot `from` on.
#[inline(always)]
fn sum<T: Entry>(pattern: Pattern<'_>, blocks: &[[T; 9]], row: usize, from: usize) -> Block {
    let lower = pattern.off_diagonal(row).lower;
    let (mut sum, mut transposed) = ([0.0; 9], [0.0; 9]);
    for block in &blocks[from..pattern.row[row + 1]] {
        (0..9).for_each(|e| sum[e] += block[e].exact());
    }
    for &LowerBlock { slot, .. } in lower {
        let block = &blocks[slot as usize];
        (0..9).for_each(|e| transposed[e] += block[e].exact());
    }
    (0..9).for_each(|e| sum[e] += transposed[3 * (e % 3) + e / 3]);
    sum
}
