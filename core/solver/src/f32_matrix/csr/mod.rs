//! Irregular patterns: a sliced ELLPACK matrix with a column index for each lane.
//!
//! Sixteen rows are multiplied at a time, each lane with the next block of its row, whose vector is gathered into registers. A block is
//! read once for both of its rows (sell ELLPACK: Kreutzer et al. 2014).

mod product;
#[cfg(test)]
mod tests;
mod vectors;

use super::sell::diagonal::Diagonal;
use super::sell::update::{Fill, NONE, Slots, Update};
use super::sell::{BANDS, BLOCKS, height};
use crate::algebra::Vec3;
use crate::lanes::aligned::Lines;
use crate::lanes::{Entry, LANES, Quad, Vectors, widest};
use crate::matrix::f32_blocks::RowSum;
use crate::matrix::pattern::Rows;
use crate::threads::Pool;
use product::Multiply;
use vectors::{UpdateDirection, UpdateResidual};

/// Sixteens of nodes in a chunk of a vector for a thread.
const CHUNK: usize = 128;

/// Blocks of the matrix with the vectors of the iteration.
#[derive(Debug)]
pub struct CsrMatrix {
    /// Rows of all bands but the last.
    height: usize,
    bands: Vec<Band>,
    /// Search direction.
    p: Vec<Quad>,
    /// Sum of steps.
    sum: Vec<Quad>,
}

/// Rows that are multiplied by one thread.
#[derive(Debug)]
struct Band {
    first: usize,
    /// Where the places of each slice begin (slices + 1).
    start: Vec<usize>,
    /// Column of each place and lane, relative to the first row; a row without a block there has its own column.
    column: Vec<[u32; LANES]>,
    slots: Vec<Slots>,
    /// Blocks by slice and place (9 x 16).
    values: Lines<f32>,
    diagonal: Diagonal,
    /// Product of its rows and of those they reach.
    y: Vec<Quad>,
    /// `p . y`
    dot: f64,
}

impl CsrMatrix {
    /// A matrix of `n` rows with this pattern.
    pub fn new(n: usize, rows: Rows<'_>) -> Self {
        let far = |i: usize| rows.around(i).2.last().map_or(0, |last| *last as usize - i);
        let reach = (0..n).map(far).max().unwrap_or(0);
        let height = height(reach);
        let bands = (0..n).step_by(height).map(|first| Band::new(first..n.min(first + height), reach, rows)).collect();
        let room = n.next_multiple_of(LANES);
        Self { height, bands, p: vec![[0.0; 4]; (room + reach).next_multiple_of(LANES)], sum: vec![[0.0; 4]; room] }
    }

    /// Memory, bytes.
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

    /// Finds `A p`, for [`CsrMatrix::take`]; gives `p . A p`.
    pub fn product(&mut self, pool: &Pool) -> f64 {
        let p = &self.p[..];
        pool.par_chunks(&mut self.bands[..], BANDS, &|_, bands| {
            bands.iter_mut().for_each(|band| widest(Multiply { band, p }));
        });
        self.bands.iter().map(|band| band.dot).sum()
    }

    /// `r -= a A p`, sixteens of rows from `first` on.
    pub fn update_residual(&self, first: usize, a: f32, r: &mut [Vectors]) {
        let (mut at, mut rest) = (LANES * first, r);
        while !rest.is_empty() {
            let (band, row) = (at / self.height, at % self.height);
            let (r, more) = rest.split_at_mut(rest.len().min((self.height - row) / LANES));
            // What the previous band added to its first rows.
            let before = band.checked_sub(1).and_then(|before| self.bands[before].y.get(self.height + row..));
            let (y, before) = (self.bands[band].y[row..].as_chunks().0, before.unwrap_or_default().as_chunks().0);
            at += LANES * r.len();
            widest(UpdateResidual { y, before, a, r });
            rest = more;
        }
    }

    /// `sum += a p`, then `p = h + beta p`.
    pub fn update_direction(&mut self, pool: &Pool, h: &[Vectors], a: f32, beta: f32) {
        let p = self.p[..LANES * h.len()].as_chunks_mut().0;
        pool.par_chunks((p, self.sum.as_chunks_mut().0), CHUNK, &|first, (p, sum)| {
            widest(UpdateDirection { h: &h[first..], a, beta, p, sum });
        });
    }

    /// Adds `scale` times the sum of steps to rows `first` on.
    pub fn add_to(&self, first: usize, scale: f64, x: &mut [Vec3]) {
        for (x, sum) in x.iter_mut().zip(&self.sum[first..]) {
            (0..3).for_each(|c| x[c] += scale * f64::from(sum[c]));
        }
    }
}

impl Update for CsrMatrix {
    fn fill<T: Entry>(
        &mut self,
        pool: &Pool,
        rows: usize,
        blocks: &[[T; 9]],
        own: impl Fn(usize) -> RowSum + Sync + Copy,
        scale: f64,
    ) {
        pool.par_chunks(&mut self.bands[..], 1, &|_, bands| {
            for Band { first, start, slots, values, diagonal, .. } in bands {
                let (first, values) = (*first, values.flat_mut());
                widest(Fill { blocks, own, scale, first, rows, start, slots, values, diagonal });
            }
        });
    }
}

impl Band {
    fn new(all: std::ops::Range<usize>, reach: usize, rows: Rows<'_>) -> Self {
        let (mut start, mut column, mut slots) = (vec![0], Vec::new(), Vec::new());
        for first in all.clone().step_by(LANES) {
            let here = first..all.end.min(first + LANES);
            let places = here.clone().map(|i| rows.around(i).2.len()).max().unwrap_or(0);
            for place in 0..places {
                let (mut columns, mut slots_here) = ([0; LANES], [NONE; LANES]);
                for (lane, i) in (first..first + LANES).enumerate() {
                    let there = here.contains(&i).then(|| rows.around(i)).filter(|(.., row)| place < row.len());
                    columns[lane] = there.map_or(i, |(.., row)| row[place] as usize) as u32 - all.start as u32;
                    slots_here[lane] = there.map_or(NONE, |(_, above, _)| (above + place) as u32);
                }
                column.push(columns);
                slots.push(slots_here);
            }
            start.push(column.len());
        }
        let slices = start.len() - 1;
        let values = Lines::new(BLOCKS * column.len());
        let y = vec![[0.0; 4]; (LANES * slices + reach).next_multiple_of(LANES)];
        Self { first: all.start, start, column, slots, values, diagonal: Diagonal::new(slices), y, dot: 0.0 }
    }
}
