//! New values for a matrix whose rows are multiplied sixteen at a time.

use super::diagonal::Diagonal;
use super::{AHEAD, BLOCKS, LANES};
use crate::step::lanes::{Entry, Lanes, Work};
use crate::step::matrix::{Matrix, Values};
use crate::step::pool::Pool;
use crate::step::rounded::Own;
use crate::step::single_update::row_sum;
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
        let (mut places, mut begin) = (slots.iter().zip(values), NONE);
        for ((slice, ends), first) in start.windows(2).enumerate().zip((first..).step_by(LANES)) {
            diagonal.put(unit, slice, (first..rows.min(first + LANES)).map(&of), scale);
            for (place, (slots, to)) in places.by_ref().take(ends[1] - ends[0]).enumerate() {
                begin = if place == 0 { slots[0] } else { begin };
                ask_ahead(blocks, (slots, begin, place));
                let mut refs = [&nothing; LANES];
                for lane in 0..LANES {
                    refs[lane] = blocks.get(slots[lane] as usize).unwrap_or(&nothing);
                }
                put(unit, refs, scale, to);
            }
        }
    }
}

/// Asks memory for slots a page ahead, and for the blocks that come so much later than the `first` of a slice, of whose rows all have
/// theirs one behind the other.
#[inline(always)]
fn ask_ahead<T>(blocks: &[[T; 9]], (slots, first, place): (&Slots, u32, usize)) {
    prefetch(slots, LANES * 4 * AHEAD);
    if first != NONE {
        let from = 9 * (first as usize + LANES * (place + AHEAD));
        for entry in (0..BLOCKS).step_by(64 / size_of::<T>()) {
            prefetch(blocks.as_flattened(), from + entry);
        }
    }
}

/// Puts the entries of blocks, times `scale`.
#[inline(always)]
pub fn put<U: Lanes, T: Entry>(unit: U, blocks: [&[T; 9]; LANES], scale: f64, to: &mut [[f32; LANES]]) {
    let entries = unit.entries(blocks, scale);
    for e in 0..9 {
        to[e] = unit.store(unit.without_dust(entries[e]));
    }
}
