//! New values for a matrix whose rows are multiplied sixteen at a time.

use super::{BLOCKS, LANES};
use crate::step::Block;
use crate::step::lanes::{Entry, Lanes, Work};
use crate::step::matrix::{Matrix, Rows, Values};
use crate::step::pool::Pool;
use crate::step::single_update::row_sum;

/// What holds the values of a matrix by slices.
pub trait Update {
    /// Takes over `blocks` off the diagonal and what they leave there, times `scale`.
    fn fill<T: Entry>(
        &mut self,
        pool: &Pool,
        blocks: (Rows<'_>, &[[T; 9]]),
        own: impl Fn(usize) -> Block + Sync + Copy,
        scale: f64,
    );

    /// Takes over new values, times `scale`.
    fn update(&mut self, pool: &Pool, matrix: &Matrix, scale: f64) {
        let rows = matrix.pattern();
        match matrix.values() {
            Values::Exact(blocks) => self.fill(pool, (rows, blocks), |i| row_sum(rows, blocks, i), scale),
            Values::Rounded(of) => self.fill(pool, (rows, of.blocks()), |i| of.own(i), scale),
        }
    }
}

/// Slices take over new values, times `scale`: `blocks` off the diagonal, and what they leave there.
pub struct Fill<'a, T, F, P> {
    pub rows: Rows<'a>,
    pub blocks: &'a [[T; 9]],
    pub own: F,
    pub scale: f64,
    /// The first row.
    pub first: usize,
    /// Of each slice's places (slices + 1).
    pub start: &'a [usize],
    /// Whether a place is for the next block of a row, by its column.
    pub takes: P,
    /// By slice: blocks of the diagonal, then those of each place (9 x 16).
    pub values: &'a mut [f32],
}

/// Where a row has no block in a place.
const NOTHING: Block = [0.0; 9];

impl<T: Entry, F: Fn(usize) -> Block, P: Fn(usize, usize, u32) -> bool> Work for Fill<'_, T, F, P> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { rows, blocks, own: of, scale, first, start, takes, values } = self;
        let mut slices = values.as_chunks_mut::<LANES>().0.chunks_exact_mut(BLOCKS / LANES);
        for (slice, ends) in start.windows(2).enumerate() {
            let first = first + LANES * slice;
            let here = first..rows.count().min(first + LANES);
            let mut own = [NOTHING; LANES];
            // Of each row's blocks above the diagonal: the first one that was not taken yet, and one past the last.
            let (mut next, mut end) = ([0; LANES], [0; LANES]);
            for (lane, i) in here.clone().enumerate() {
                own[lane] = of(i);
                let (_, above, columns) = rows.around(i);
                (next[lane], end[lane]) = (above, above + columns.len());
            }
            let (mut diagonal, nothing) = ([&NOTHING; LANES], [T::default(); 9]);
            for lane in 0..LANES {
                diagonal[lane] = &own[lane];
            }
            put(unit, diagonal, scale, slices.next().expect("a slice has a diagonal"));
            for (place, to) in (ends[0]..ends[1]).zip(&mut slices) {
                let mut refs = [&nothing; LANES];
                for (lane, i) in here.clone().enumerate() {
                    if next[lane] < end[lane] && takes(place, i, rows.column(next[lane])) {
                        refs[lane] = &blocks[next[lane]];
                        next[lane] += 1;
                    }
                }
                put(unit, refs, scale, to);
            }
        }
    }
}

#[inline(always)]
fn put<U: Lanes, T: Entry>(unit: U, blocks: [&[T; 9]; LANES], scale: f64, to: &mut [[f32; LANES]]) {
    let entries = unit.entries(blocks, scale);
    for e in 0..9 {
        to[e] = unit.store(unit.without_dust(entries[e]));
    }
}
