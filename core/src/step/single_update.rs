//! New values for a matrix in single precision ([`super::single`]).

use super::Block;
use super::lanes::Entry;
use super::matrix::{Matrix, Rows, Values};
use super::pool::Pool;
use super::single::{SingleBlock, dusted};
use std::ops::Range;

/// Blocks in a piece of work for a thread.
const BLOCKS: usize = 1024;

/// The blocks in `slots` times `scale`, rounded.
pub fn round(pool: &Pool, (scale, matrix): (f64, &Matrix), slots: Range<usize>, out: &mut [SingleBlock]) {
    match matrix.values() {
        Values::Exact(from) => copy(pool, scale, &from[slots], out),
        Values::Rounded(from) => {
            copy(pool, scale, &from.blocks()[slots.clone()], out);
            let is_diagonal = |(i, of_row): &(usize, Range<usize>)| matrix.diagonal_slot(*i) == of_row.start;
            for (i, of_row) in matrix.rows_of(slots.clone()).filter(is_diagonal) {
                out[of_row.start - slots.start] = from.diagonal(i).map(|value| dusted(value.rounded(scale)));
            }
        }
    }
}

fn copy<T: Entry>(pool: &Pool, scale: f64, from: &[[T; 9]], out: &mut [SingleBlock]) {
    pool.pieces(out, BLOCKS, &|first, out: &mut [SingleBlock]| {
        pulp::Arch::new().dispatch(Rounded { scale, from: &from[first..first + out.len()], out });
    });
}

struct Rounded<'a, T> {
    scale: f64,
    from: &'a [[T; 9]],
    out: &'a mut [SingleBlock],
}

impl<T: Entry> pulp::NullaryFnOnce for Rounded<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (from, out) = (self.from.as_flattened(), self.out.as_flattened_mut());
        for (out, from) in out.iter_mut().zip(from) {
            *out = dusted(from.rounded(self.scale));
        }
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
