//! Irregular patterns: a SELL-16 matrix (sliced ELLPACK, Kreutzer et al. 2014) with a column index for each lane.
//!
//! Sixteen rows, a slice, are multiplied at a time, each in a lane of the vector unit. At each place of a slice every lane has the next block
//! above the diagonal of its row; vectors of the columns are gathered into registers. The block also stands for its transpose below the
//! diagonal: that product is scattered to the rows of the columns.

mod product;
#[cfg(test)]
mod tests;
mod vectors;

use super::sell::diagonal::Diagonal;
use super::sell::update::{Fill, NONE, Slots, Update};
use super::sell::{BANDS, BLOCKS, band_height};
use crate::algebra::Vec3;
use crate::lanes::aligned::Lines;
use crate::lanes::{Entry, LANES, Quad, Vectors, widest};
use crate::matrix::f32_blocks::RowSum;
use crate::matrix::pattern::Pattern;
use crate::threads::Pool;
use product::Multiply;
use std::ops::Range;
use vectors::{UpdateDirection, UpdateResidual};

/// Slices in a chunk of a vector for a thread.
const CHUNK: usize = 128;

/// A matrix with the search direction and the sum of steps of an iteration.
#[derive(Debug)]
pub struct SellColumns {
    /// Rows of each band; the last may have fewer.
    height: usize,
    bands: Vec<Band>,
    /// Search direction, as far as rows reach, padded with zeros.
    p: Vec<Quad>,
    /// Sum of steps.
    sum: Vec<Quad>,
}

/// Consecutive rows that one thread multiplies.
#[derive(Debug)]
struct Band {
    /// The first row.
    first: usize,
    /// Where the places of each slice begin (slices + 1).
    start: Vec<usize>,
    /// Column of each place and lane, relative to the first row of the band; a row without a block there has its own index.
    column: Vec<[u32; LANES]>,
    /// Slots of the blocks of each place.
    slots: Vec<Slots>,
    /// Entries of the blocks of each place (9 x 16).
    values: Lines<f32>,
    /// Sum of the blocks of each row, which takes the place of its diagonal block.
    diagonal: Diagonal,
    /// Product: of the rows of the band, and what its blocks below the diagonal add to later rows.
    y: Vec<Quad>,
    /// `p . y`.
    dot: f64,
}

impl SellColumns {
    /// A matrix of `n` rows with this pattern.
    pub fn new(n: usize, pattern: Pattern<'_>) -> Self {
        let farthest = |i: usize| pattern.off_diagonal(i).columns.last().map_or(0, |last| *last as usize - i);
        let reach = (0..n).map(farthest).max().unwrap_or(0);
        let height = band_height(reach);
        let band = |first: usize| Band::new(first..n.min(first + height), reach, pattern);
        let bands = (0..n).step_by(height).map(band).collect();
        let padded = n.next_multiple_of(LANES);
        Self { height, bands, p: vec![[0.0; 4]; (padded + reach).next_multiple_of(LANES)], sum: vec![[0.0; 4]; padded] }
    }

    /// Memory of the bands and vectors, bytes.
    pub fn bytes(&self) -> usize {
        let of = |b: &Band| {
            b.values.bytes() + b.diagonal.bytes() + 8 * LANES * b.column.len() + 16 * b.y.len() + 8 * b.start.len()
        };
        16 * (self.p.len() + self.sum.len()) + self.bands.iter().map(of).sum::<usize>()
    }

    /// Sets direction and sum to zero.
    pub fn start(&mut self) {
        self.p.fill([0.0; 4]);
        self.sum.fill([0.0; 4]);
    }

    /// Computes `A p`, which [`SellColumns::update_residual`] uses. Returns `p . A p`.
    pub fn product(&mut self, pool: &Pool) -> f64 {
        let p = &self.p[..];
        pool.par_chunks(&mut self.bands[..], BANDS, &|_, bands| {
            bands.iter_mut().for_each(|band| widest(Multiply { band, p }));
        });
        self.bands.iter().map(|band| band.dot).sum()
    }

    /// `r -= a A p` with the last product, for the rows from `16 first` on, by sixteen.
    pub fn update_residual(&self, first: usize, a: f32, r: &mut [Vectors]) {
        let (mut at, mut rest) = (LANES * first, r);
        while !rest.is_empty() {
            let (band, row) = (at / self.height, at % self.height);
            let (r, later) = rest.split_at_mut(rest.len().min((self.height - row) / LANES));
            // What the blocks of the previous band add to the first rows of this one.
            let before = band.checked_sub(1).and_then(|before| self.bands[before].y.get(self.height + row..));
            let (y, before) = (self.bands[band].y[row..].as_chunks().0, before.unwrap_or_default().as_chunks().0);
            at += LANES * r.len();
            widest(UpdateResidual { y, before, a, r });
            rest = later;
        }
    }

    /// `sum += a p`, then `p = h + beta p`.
    pub fn update_direction(&mut self, pool: &Pool, h: &[Vectors], a: f32, beta: f32) {
        let p = self.p[..LANES * h.len()].as_chunks_mut().0;
        pool.par_chunks((p, self.sum.as_chunks_mut().0), CHUNK, &|first, (p, sum)| {
            widest(UpdateDirection { h: &h[first..], a, beta, p, sum });
        });
    }

    /// Adds `scale` times the sum of steps to `x`, whose first row is `first`.
    pub fn add_to(&self, first: usize, scale: f64, x: &mut [Vec3]) {
        for (x, sum) in x.iter_mut().zip(&self.sum[first..]) {
            (0..3).for_each(|c| x[c] += scale * f64::from(sum[c]));
        }
    }
}

impl Update for SellColumns {
    fn fill<T: Entry>(
        &mut self,
        pool: &Pool,
        rows: usize,
        blocks: &[[T; 9]],
        row_sum: impl Fn(usize) -> RowSum + Sync + Copy,
        scale: f64,
    ) {
        pool.par_chunks(&mut self.bands[..], 1, &|_, bands| {
            for Band { first, start, slots, values, diagonal, .. } in bands {
                let (first, values) = (*first, values.flat_mut());
                widest(Fill { blocks, row_sum, scale, first, rows, start, slots, values, diagonal });
            }
        });
    }
}

impl Band {
    /// A band of the given rows of a matrix whose blocks lie at most `reach` from the diagonal.
    fn new(rows: Range<usize>, reach: usize, pattern: Pattern<'_>) -> Self {
        let (mut start, mut column, mut slots) = (vec![0], Vec::new(), Vec::new());
        for first in rows.clone().step_by(LANES) {
            let slice = first..rows.end.min(first + LANES);
            let places = slice.clone().map(|i| pattern.off_diagonal(i).columns.len()).max().unwrap_or(0);
            for place in 0..places {
                let (mut place_columns, mut place_slots) = ([0; LANES], [NONE; LANES]);
                for (lane, i) in (first..first + LANES).enumerate() {
                    let row = slice.contains(&i).then(|| pattern.off_diagonal(i));
                    let row = row.filter(|row| place < row.columns.len());
                    place_columns[lane] = row.map_or(i, |row| row.columns[place] as usize) as u32 - rows.start as u32;
                    place_slots[lane] = row.map_or(NONE, |row| (row.first_slot + place) as u32);
                }
                column.push(place_columns);
                slots.push(place_slots);
            }
            start.push(column.len());
        }
        let slices = start.len() - 1;
        let values = Lines::new(BLOCKS * column.len());
        let y = vec![[0.0; 4]; (LANES * slices + reach).next_multiple_of(LANES)];
        Self { first: rows.start, start, column, slots, values, diagonal: Diagonal::new(slices), y, dot: 0.0 }
    }
}
