//! New values for a matrix with rows that lie alike ([`super`]).

use super::{BLOCKS, Band, LANES};
use crate::step::Block;
use crate::step::lanes::{Lanes, Work};
use crate::step::matrix::Matrix;
use crate::step::single_update::row_sum;

/// A band takes over new values, times `scale`.
pub struct Fill<'a> {
    pub matrix: &'a Matrix,
    pub scale: f64,
    pub band: &'a mut Band,
}

/// Where a row has no block at a distance.
const NOTHING: Block = [0.0; 9];

impl Work for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { matrix, scale, band: Band { first, start, distance, values, .. } } = self;
        let (rows, blocks) = (matrix.pattern(), matrix.values());
        let mut slices = values.flat_mut().as_chunks_mut::<LANES>().0.chunks_exact_mut(BLOCKS / LANES);
        for (slice, ends) in start.windows(2).enumerate() {
            let (first, distances) = (*first + LANES * slice, &distance[ends[0]..ends[1]]);
            let here = first..matrix.rows().min(first + LANES);
            let mut own = [NOTHING; LANES];
            // Of each row's blocks above the diagonal: the first one that was not taken yet, and one past the last.
            let (mut next, mut end) = ([0; LANES], [0; LANES]);
            for (lane, i) in here.clone().enumerate() {
                own[lane] = row_sum(matrix, i);
                let (_, above, columns) = rows.around(i);
                (next[lane], end[lane]) = (above, above + columns.len());
            }
            let mut refs = [&NOTHING; LANES];
            for lane in 0..LANES {
                refs[lane] = &own[lane];
            }
            put(unit, refs, scale, slices.next().expect("a slice has a diagonal"));
            for (distance, to) in distances.iter().zip(&mut slices) {
                refs = [&NOTHING; LANES];
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
fn put<U: Lanes>(unit: U, blocks: [&Block; LANES], scale: f64, to: &mut [[f32; LANES]]) {
    let entries = unit.entries(blocks, scale);
    for e in 0..9 {
        to[e] = unit.store(unit.without_dust(entries[e]));
    }
}
