//! Rounding of the blocks of a matrix to single precision ([`crate::f32_matrix`]).

use crate::algebra::SingleBlock;
use crate::lanes::{Entry, flush_denormals};
use crate::matrix::{Matrix, Values};
use crate::threads::Pool;
use pliant_plugin_api::lanes::vector_unit;
use std::ops::Range;

/// Blocks in a chunk of work for a thread.
const BLOCKS: usize = 1024;

/// Writes the blocks in `slots` times `scale`, rounded, to `out`.
pub fn round(pool: &Pool, scale: f64, matrix: &Matrix, slots: Range<usize>, out: &mut [SingleBlock]) {
    match matrix.values() {
        Values::F64(from) => copy(pool, scale, &from[slots], out),
        Values::F32(from) => {
            copy(pool, scale, &from.blocks()[slots.clone()], out);
            // The diagonal blocks among `slots`: a matrix in single precision has them apart.
            let begins_with_diagonal = |(i, row): &(usize, Range<usize>)| matrix.diagonal_slot(*i) == row.start;
            for (i, row) in matrix.rows_of(slots.clone()).filter(begins_with_diagonal) {
                out[row.start - slots.start] = from.diagonal(i).map(|value| flush_denormals(value.rounded(scale)));
            }
        }
    }
}

/// `out = scale from`, rounded.
fn copy<T: Entry>(pool: &Pool, scale: f64, from: &[[T; 9]], out: &mut [SingleBlock]) {
    pool.par_chunks(out, BLOCKS, &|first, out: &mut [SingleBlock]| {
        vector_unit().dispatch(Round { scale, from: &from[first..first + out.len()], out });
    });
}

/// The loop of [`copy`].
struct Round<'a, T> {
    scale: f64,
    from: &'a [[T; 9]],
    out: &'a mut [SingleBlock],
}

impl<T: Entry> pulp::NullaryFnOnce for Round<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (from, out) = (self.from.as_flattened(), self.out.as_flattened_mut());
        for (out, from) in out.iter_mut().zip(from) {
            *out = flush_denormals(from.rounded(self.scale));
        }
    }
}
