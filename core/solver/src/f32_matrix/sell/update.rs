//! Loading of values into a SELL-16 matrix.

use super::diagonal::{Diagonal, put};
use super::{AHEAD, BLOCKS};
use crate::lanes::{Entry, LANES, Lanes, Work};
use crate::matrix::f32_blocks::RowSum;
use crate::matrix::pattern::row_sum;
use crate::matrix::{Matrix, Values};
use crate::threads::Pool;
use pliant_plugin_api::prefetch;

/// A matrix that is stored by slices of sixteen rows.
pub trait Update {
    /// Loads the blocks off the diagonal, by slot, and the row sums of a matrix of `rows` rows, times `scale`.
    fn fill<T: Entry>(
        &mut self,
        pool: &Pool,
        rows: usize,
        blocks: &[[T; 9]],
        row_sum: impl Fn(usize) -> RowSum + Sync + Copy,
        scale: f64,
    );

    /// Loads the values of a matrix, times `scale`.
    fn update(&mut self, pool: &Pool, matrix: &Matrix, scale: f64) {
        let pattern = matrix.pattern();
        match matrix.values() {
            Values::F64(blocks) => {
                self.fill(pool, matrix.rows(), blocks, |i| RowSum::Block(row_sum(pattern, blocks, i)), scale)
            }
            Values::F32(of) => self.fill(pool, matrix.rows(), of.blocks(), |i| of.row_sum(i), scale),
        }
    }
}

/// Slots of the blocks of a slice at one place, by lane.
pub type Slots = [u32; LANES];

/// Slot of a row without a block at that place.
pub const NONE: u32 = u32::MAX;

/// The loop that loads the values of a band, times `scale`.
pub struct Fill<'a, T, F> {
    /// Blocks by slot.
    pub blocks: &'a [[T; 9]],
    /// Row sum of each row of the matrix.
    pub row_sum: F,
    /// Factor, a power of two.
    pub scale: f64,
    /// First row of the band.
    pub first: usize,
    /// Number of rows of the matrix.
    pub rows: usize,
    /// Where the places of each slice begin (slices + 1).
    pub start: &'a [usize],
    /// Slots of the blocks of each place.
    pub slots: &'a [Slots],
    /// Entries of the blocks of each place (9 x 16), to be written.
    pub values: &'a mut [f32],
    /// Row sums, to be written.
    pub diagonal: &'a mut Diagonal,
}

impl<T: Entry, F: Fn(usize) -> RowSum> Work for Fill<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { blocks, row_sum, scale, first, rows, start, slots, values, diagonal } = self;
        let (zero, values) = ([T::default(); 9], values.as_chunks_mut().0.chunks_exact_mut(BLOCKS / LANES));
        let (flat, mut places) = (blocks.as_flattened(), slots.iter().zip(values));
        for ((slice, ends), first) in start.windows(2).enumerate().zip((first..).step_by(LANES)) {
            diagonal.put(unit, slice, (first..rows.min(first + LANES)).map(&row_sum), scale);
            for (place, (slots, to)) in places.by_ref().take(ends[1] - ends[0]).enumerate() {
                // The blocks of a slice are consecutive. Without a block in lane 0 the address is out of range, which prefetch ignores.
                let from = (slots[0] as usize).wrapping_add(LANES * (place + AHEAD)).wrapping_mul(9);
                for entry in (0..BLOCKS).step_by(64 / size_of::<T>()) {
                    prefetch(flat, from.wrapping_add(entry));
                }
                // Slots one page ahead.
                prefetch(slots, LANES * 4 * AHEAD);
                let mut refs = [&zero; LANES];
                for lane in 0..LANES {
                    refs[lane] = blocks.get(slots[lane] as usize).unwrap_or(&zero);
                }
                put(unit, refs, scale, to);
            }
        }
    }
}
