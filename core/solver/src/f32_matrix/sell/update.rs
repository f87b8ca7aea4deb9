//! New values for a matrix whose rows are multiplied sixteen at a time.

use super::diagonal::{Diagonal, put};
use super::{AHEAD, BLOCKS};
use crate::lanes::{Entry, LANES, Lanes, Work};
use crate::matrix::f32_blocks::RowSum;
use crate::matrix::pattern::row_sum;
use crate::matrix::{Matrix, Values};
use crate::threads::Pool;
use pliant_plugin_api::prefetch;

/// A matrix stored by slices of sixteen rows.
pub trait Update {
    /// Loads the blocks off the diagonal and the row sums of a matrix of `rows` rows, times `scale`.
    fn fill<T: Entry>(
        &mut self,
        pool: &Pool,
        rows: usize,
        blocks: &[[T; 9]],
        own: impl Fn(usize) -> RowSum + Sync + Copy,
        scale: f64,
    );

    /// Loads the values of a matrix, times `scale`.
    fn update(&mut self, pool: &Pool, matrix: &Matrix, scale: f64) {
        let rows = matrix.pattern();
        match matrix.values() {
            Values::F64(blocks) => {
                self.fill(pool, matrix.rows(), blocks, |i| RowSum::Block(row_sum(rows, blocks, i)), scale)
            }
            Values::F32(of) => self.fill(pool, matrix.rows(), of.blocks(), |i| of.own(i), scale),
        }
    }
}

/// Slots of the blocks of sixteen rows at one place.
pub type Slots = [u32; LANES];

/// Slot of a row without a block at that place.
pub const NONE: u32 = u32::MAX;

/// Slices take over new values, times `scale`: `blocks` off the diagonal, and what they leave there.
pub struct Fill<'a, T, F> {
    pub blocks: &'a [[T; 9]],
    pub own: F,
    pub scale: f64,
    /// The first row, and how many the matrix has.
    pub first: usize,
    pub rows: usize,
    /// Of each slice's places (slices + 1).
    pub start: &'a [usize],
    pub slots: &'a [Slots],
    /// By place (9 x 16).
    pub values: &'a mut [f32],
    pub diagonal: &'a mut Diagonal,
}

impl<T: Entry, F: Fn(usize) -> RowSum> Work for Fill<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { blocks, own: of, scale, first, rows, start, slots, values, diagonal } = self;
        let (nothing, values) = ([T::default(); 9], values.as_chunks_mut().0.chunks_exact_mut(BLOCKS / LANES));
        let (flat, mut places) = (blocks.as_flattened(), slots.iter().zip(values));
        for ((slice, ends), first) in start.windows(2).enumerate().zip((first..).step_by(LANES)) {
            diagonal.put(unit, slice, (first..rows.min(first + LANES)).map(&of), scale);
            for (place, (slots, to)) in places.by_ref().take(ends[1] - ends[0]).enumerate() {
                // Of a slice's rows all have their blocks one behind the other. Where a row has none this asks for what is nowhere.
                let from = (slots[0] as usize).wrapping_add(LANES * (place + AHEAD)).wrapping_mul(9);
                for entry in (0..BLOCKS).step_by(64 / size_of::<T>()) {
                    prefetch(flat, from.wrapping_add(entry));
                }
                // A page of slots.
                prefetch(slots, LANES * 4 * AHEAD);
                let mut refs = [&nothing; LANES];
                for lane in 0..LANES {
                    refs[lane] = blocks.get(slots[lane] as usize).unwrap_or(&nothing);
                }
                put(unit, refs, scale, to);
            }
        }
    }
}
