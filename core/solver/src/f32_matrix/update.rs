//! New values for a matrix in single precision ([`crate::f32_matrix`]).

use crate::algebra::SingleBlock;
use crate::lanes::{Entry, flush_denormals};
use crate::matrix::{Matrix, Values};
use crate::threads::Pool;
use std::ops::Range;

/// Blocks in a chunk of work for a thread.
const BLOCKS: usize = 1024;

/// The blocks in `slots` times `scale`, rounded.
pub fn round(pool: &Pool, scale: f64, matrix: &Matrix, slots: Range<usize>, out: &mut [SingleBlock]) {
    match matrix.values() {
        Values::F64(from) => copy(pool, scale, &from[slots], out),
        Values::F32(from) => {
            copy(pool, scale, &from.blocks()[slots.clone()], out);
            let is_diagonal = |(i, of_row): &(usize, Range<usize>)| matrix.diagonal_slot(*i) == of_row.start;
            for (i, of_row) in matrix.rows_of(slots.clone()).filter(is_diagonal) {
                out[of_row.start - slots.start] = from.diagonal(i).map(|value| flush_denormals(value.rounded(scale)));
            }
        }
    }
}

fn copy<T: Entry>(pool: &Pool, scale: f64, from: &[[T; 9]], out: &mut [SingleBlock]) {
    pool.par_chunks(out, BLOCKS, &|first, out: &mut [SingleBlock]| {
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
            *out = flush_denormals(from.rounded(self.scale));
        }
    }
}
