//! New values for a matrix whose rows are multiplied sixteen at a time.

use super::diagonal::{Diagonal, put};
use super::{AHEAD, BLOCKS};
use crate::lanes::{Entry, LANES, Lanes, Work};
use crate::matrix::rounded::Own;
use crate::matrix::rows::row_sum;
use crate::matrix::{Matrix, Values};
use crate::threads::Pool;
use pliant_plugin_api::prefetch;

/// What holds the values of a matrix by slices.
pub trait Update {
    /// Takes over `blocks` off the diagonal of so many rows and what they leave there, times `scale`.
    fn fill<T: Entry>(
        &mut self,
        pool: &Pool,
        blocks: (usize, &[[T; 9]]),
        own: impl Fn(usize) -> Own + Sync + Copy,
        scale: f64,
    );

    /// Takes over new values, times `scale`.
    fn update(&mut self, pool: &Pool, matrix: &Matrix, scale: f64) {
        let rows = matrix.pattern();
        match matrix.values() {
            Values::Exact(blocks) => {
                self.fill(pool, (matrix.rows(), blocks), |i| Own::Block(row_sum(rows, blocks, i)), scale)
            }
            Values::Rounded(of) => self.fill(pool, (matrix.rows(), of.blocks()), |i| of.own(i), scale),
        }
    }
}

/// Slots of the blocks that sixteen rows have in one place.
pub type Slots = [u32; LANES];

/// Of a row that has none there.
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

impl<T: Entry, F: Fn(usize) -> Own> Work for Fill<'_, T, F> {
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
