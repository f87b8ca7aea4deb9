//! New values for a matrix in single precision ([`super::single`]).

use super::Block;
use super::matrix::Matrix;
use super::pool::Pool;
use super::single::{SingleBlock, dusted};

/// Blocks in a piece of work for a thread.
const BLOCKS: usize = 1024;
/// Rows in a piece.
const ROWS: usize = 256;

/// `out = scale of`, rounded.
pub fn round(pool: &Pool, scale: f64, of: &[Block], out: &mut [SingleBlock]) {
    pool.pieces(out, BLOCKS, &|first, out: &mut [SingleBlock]| {
        pulp::Arch::new().dispatch(Rounded { scale, from: &of[first..first + out.len()], out });
    });
}

/// What the blocks of each row leave of the diagonal, times `scale`.
pub fn row_sums(pool: &Pool, scale: f64, matrix: &Matrix, out: &mut [SingleBlock]) {
    pool.pieces(out, ROWS, &|first, out| pulp::Arch::new().dispatch(Sums { scale, matrix, first, out }));
}

struct Rounded<'a> {
    scale: f64,
    from: &'a [Block],
    out: &'a mut [SingleBlock],
}

impl pulp::NullaryFnOnce for Rounded<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (from, out) = (self.from.as_flattened(), self.out.as_flattened_mut());
        for (out, from) in out.iter_mut().zip(from) {
            *out = dusted((self.scale * from) as f32);
        }
    }
}

struct Sums<'a> {
    scale: f64,
    matrix: &'a Matrix,
    first: usize,
    out: &'a mut [SingleBlock],
}

impl pulp::NullaryFnOnce for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (at, out) in self.out.iter_mut().enumerate() {
            let sum = row_sum(self.matrix, self.first + at);
            (0..9).for_each(|e| out[e] = (self.scale * sum[e]) as f32);
        }
    }
}

/// Sum of all blocks of a row.
#[inline(always)]
pub fn row_sum(matrix: &Matrix, row: usize) -> Block {
    let (values, (lower, above, columns)) = (matrix.values(), matrix.pattern().around(row));
    let (mut straight, mut turned) = ([0.0; 9], [0.0; 9]);
    for block in &values[above - 1..above + columns.len()] {
        (0..9).for_each(|e| straight[e] += block[e]);
    }
    for &(_, slot) in lower {
        let block = &values[slot as usize];
        (0..9).for_each(|e| turned[e] += block[e]);
    }
    (0..9).for_each(|e| straight[e] += turned[3 * (e % 3) + e / 3]);
    straight
}
