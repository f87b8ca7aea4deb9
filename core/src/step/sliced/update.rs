//! New values for a matrix whose rows are multiplied sixteen at a time.

use super::{BLOCKS, LANES};
use crate::step::Block;
use crate::step::lanes::{Entry, Lanes, Work};
use crate::step::matrix::{Matrix, Values};
use crate::step::pool::Pool;
use crate::step::rounded::Own;
use crate::step::single_update::row_sum;
use std::ops::Range;

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
    /// Rows.
    pub all: Range<usize>,
    /// Of each slice's places (slices + 1).
    pub start: &'a [usize],
    pub slots: &'a [Slots],
    /// By slice: blocks of the diagonal, then those of each place (9 x 16).
    pub values: &'a mut [f32],
    /// Whether the first of a slice are masses alone: then the other eight of their entries are left as they are (slices).
    pub masses: &'a mut [bool],
}

/// Where a row has no block in a place.
const NOTHING: Block = [0.0; 9];

impl<T: Entry, F: Fn(usize) -> Own> Work for Fill<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { blocks, own: of, scale, all, start, slots, values, masses } = self;
        let (nothing, mut slices) = ([T::default(); 9], values.as_chunks_mut().0.chunks_exact_mut(BLOCKS / LANES));
        for ((ends, masses), first) in start.windows(2).zip(masses).zip(all.clone().step_by(LANES)) {
            let diagonal = slices.next().expect("a slice has a diagonal");
            *masses = put_own(unit, (first..all.end.min(first + LANES)).map(&of), scale, diagonal);
            for (slots, to) in slots[ends[0]..ends[1]].iter().zip(&mut slices) {
                let mut refs = [&nothing; LANES];
                for lane in 0..LANES {
                    refs[lane] = blocks.get(slots[lane] as usize).unwrap_or(&nothing);
                }
                put(unit, refs, scale, to);
            }
        }
    }
}

/// Puts what the blocks of rows leave; gives whether that is masses alone.
#[inline(always)]
fn put_own<U: Lanes>(unit: U, rows: impl Iterator<Item = Own>, scale: f64, to: &mut [[f32; LANES]]) -> bool {
    let (mut masses, mut blocks, mut all) = ([0.0; LANES], [NOTHING; LANES], true);
    for ((mass, block), own) in masses.iter_mut().zip(&mut blocks).zip(rows) {
        match own {
            Own::Mass(m) => (*mass, block[0], block[4], block[8]) = (m.rounded(scale), m, m, m),
            Own::Block(own) => (*block, all) = (own, false),
        }
    }
    if all {
        to[0] = unit.store(unit.without_dust(unit.load(&masses)));
        return true;
    }
    let mut refs = [&NOTHING; LANES];
    for lane in 0..LANES {
        refs[lane] = &blocks[lane];
    }
    put(unit, refs, scale, to);
    false
}

#[inline(always)]
fn put<U: Lanes, T: Entry>(unit: U, blocks: [&[T; 9]; LANES], scale: f64, to: &mut [[f32; LANES]]) {
    let entries = unit.entries(blocks, scale);
    for e in 0..9 {
        to[e] = unit.store(unit.without_dust(entries[e]));
    }
}
