//! The pattern of a matrix, and what the blocks of one of its rows add up to.

use crate::algebra::{Block, SingleBlock};
use crate::lanes::Entry;

/// Where the blocks of a matrix are.
#[derive(Clone, Copy)]
pub struct Rows<'a> {
    pub row: &'a [usize],
    pub column: &'a [u32],
    pub lower_row: &'a [usize],
    pub lower: &'a [(u32, u32)],
}

impl<'a> Rows<'a> {
    /// Rows there are.
    pub fn count(&self) -> usize {
        self.row.len() - 1
    }

    /// Blocks of row i below the diagonal by column and slot, the slot of the first one above it, and the columns of those.
    #[inline(always)]
    pub fn around(&self, i: usize) -> (&'a [(u32, u32)], usize, &'a [u32]) {
        let above = self.row[i] + 1..self.row[i + 1];
        (&self.lower[self.lower_row[i]..self.lower_row[i + 1]], above.start, &self.column[above])
    }
}

/// Sum of all blocks of a row.
#[inline(always)]
pub fn row_sum(rows: Rows<'_>, blocks: &[Block], row: usize) -> Block {
    let (_, above, _) = rows.around(row);
    sum(rows, blocks, row, above - 1)
}

/// Sum of the blocks of a row off the diagonal.
#[inline(always)]
pub fn others_sum(rows: Rows<'_>, blocks: &[SingleBlock], row: usize) -> Block {
    let (_, above, _) = rows.around(row);
    sum(rows, blocks, row, above)
}

/// Sum of the blocks below the diagonal, and of those from a slot on.
#[inline(always)]
fn sum<T: Entry>(rows: Rows<'_>, blocks: &[[T; 9]], row: usize, from: usize) -> Block {
    let (lower, above, columns) = rows.around(row);
    let (mut straight, mut turned) = ([0.0; 9], [0.0; 9]);
    for block in &blocks[from..above + columns.len()] {
        (0..9).for_each(|e| straight[e] += block[e].exact());
    }
    for &(_, slot) in lower {
        let block = &blocks[slot as usize];
        (0..9).for_each(|e| turned[e] += block[e].exact());
    }
    (0..9).for_each(|e| straight[e] += turned[3 * (e % 3) + e / 3]);
    straight
}
