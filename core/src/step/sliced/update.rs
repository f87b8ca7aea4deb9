//! New values for a matrix with rows that lie alike ([`super`]).

use super::{BLOCKS, Band, LANES};
use crate::step::Block;
use crate::step::lanes::{Entry, Lanes, Work};
use crate::step::matrix::Rows;

/// A band takes over new values, times `scale`: `blocks` off the diagonal, and what they leave there.
pub struct Fill<'a, T, F> {
    pub rows: Rows<'a>,
    pub blocks: &'a [[T; 9]],
    pub own: F,
    pub scale: f64,
    pub band: &'a mut Band,
}

/// Where a row has no block at a distance.
const NOTHING: Block = [0.0; 9];

impl<T: Entry, F: Fn(usize) -> Block> Work for Fill<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { rows, blocks, own: of, scale, band: Band { first, start, distance, values, .. } } = self;
        let mut slices = values.flat_mut().as_chunks_mut::<LANES>().0.chunks_exact_mut(BLOCKS / LANES);
        for (slice, ends) in start.windows(2).enumerate() {
            let (first, distances) = (*first + LANES * slice, &distance[ends[0]..ends[1]]);
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
            for (distance, to) in distances.iter().zip(&mut slices) {
                let mut refs = [&nothing; LANES];
                for (lane, i) in here.clone().enumerate() {
                    if next[lane] < end[lane] && rows.column(next[lane]) == i as u32 + distance {
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
