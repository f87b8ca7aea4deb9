//! A descent with rows that do not lie alike.
//!
//! Sixteen rows are multiplied at a time, a lane with the next block of its row, wherever that is: what it is multiplied with is put
//! together in registers. A block is read once for both of its rows (sliced ELLPACK: Kreutzer et al. 2014).

mod product;
#[cfg(test)]
mod tests;
mod vectors;

use super::sliced::diagonal::Diagonal;
use super::sliced::update::{Fill, NONE, Slots, Update};
use super::sliced::{BANDS, BLOCKS, height};
use crate::algebra::Vec3;
use crate::lanes::aligned::Lines;
use crate::lanes::{Entry, LANES, Quad, Vectors, widest};
use crate::matrix::rounded::Own;
use crate::matrix::rows::Rows;
use crate::threads::Pool;
use product::Multiply;
use vectors::{Take, Turn};

/// Sixteens of nodes in a piece of a vector for a thread.
const PIECE: usize = 128;

/// Blocks of a matrix, and the vectors that are multiplied with it.
#[derive(Debug)]
pub struct Each {
    /// Rows of all bands but the last.
    height: usize,
    bands: Vec<Band>,
    /// The direction of descent, as far as rows reach, and how far it has gone in all.
    p: Vec<Quad>,
    sum: Vec<Quad>,
}

/// Rows that are multiplied by one thread.
#[derive(Debug)]
struct Band {
    first: usize,
    /// Of each slice's places (slices + 1).
    start: Vec<usize>,
    /// By place and lane, counted from the first row, and which blocks; rows without one there have their own column.
    column: Vec<[u32; LANES]>,
    slots: Vec<Slots>,
    /// By slice and place (9 x 16).
    values: Lines<f32>,
    diagonal: Diagonal,
    /// Of its rows and what they reach.
    y: Vec<Quad>,
    /// `p . y`
    dot: f64,
}

impl Each {
    /// For a pattern.
    pub fn new(n: usize, rows: Rows<'_>) -> Self {
        let far = |i: usize| rows.around(i).2.last().map_or(0, |last| *last as usize - i);
        let reach = (0..n).map(far).max().unwrap_or(0);
        let height = height(reach);
        let bands = (0..n).step_by(height).map(|first| Band::new(first..n.min(first + height), reach, rows)).collect();
        let room = n.next_multiple_of(LANES);
        Self { height, bands, p: vec![[0.0; 4]; (room + reach).next_multiple_of(LANES)], sum: vec![[0.0; 4]; room] }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of = |b: &Band| {
            b.values.bytes() + b.diagonal.bytes() + 8 * LANES * b.column.len() + 16 * b.y.len() + 8 * b.start.len()
        };
        16 * (self.p.len() + self.sum.len()) + self.bands.iter().map(of).sum::<usize>()
    }

    /// `p = 0`, and nothing gone.
    pub fn start(&mut self) {
        self.p.fill([0.0; 4]);
        self.sum.fill([0.0; 4]);
    }

    /// Finds `A p`, for [`Each::take`]; gives `p . A p`.
    pub fn product(&mut self, pool: &Pool) -> f64 {
        let p = &self.p[..];
        pool.pieces(&mut self.bands[..], BANDS, &|_, bands| {
            bands.iter_mut().for_each(|band| widest(Multiply { band, p }));
        });
        self.bands.iter().map(|band| band.dot).sum()
    }

    /// `r -= a A p`, sixteens of rows from `first` on.
    pub fn take(&self, first: usize, a: f32, r: &mut [Vectors]) {
        let (mut at, mut rest) = (LANES * first, r);
        while !rest.is_empty() {
            let (band, row) = (at / self.height, at % self.height);
            let (r, more) = rest.split_at_mut(rest.len().min((self.height - row) / LANES));
            // What the band before gave to its first rows.
            let before = band.checked_sub(1).and_then(|before| self.bands[before].y.get(self.height + row..));
            let (y, before) = (self.bands[band].y[row..].as_chunks().0, before.unwrap_or_default().as_chunks().0);
            at += LANES * r.len();
            widest(Take { y, before, a, r });
            rest = more;
        }
    }

    /// Goes by `a`, then `p = h + beta p`.
    pub fn turn(&mut self, pool: &Pool, h: &[Vectors], a: f32, beta: f32) {
        let p = self.p[..LANES * h.len()].as_chunks_mut().0;
        pool.pieces((p, self.sum.as_chunks_mut().0), PIECE, &|first, (p, sum)| {
            widest(Turn { h: &h[first..], a, beta, p, sum });
        });
    }

    /// Adds `scale` times all that was gone to rows `first` on.
    pub fn add_to(&self, first: usize, scale: f64, x: &mut [Vec3]) {
        for (x, sum) in x.iter_mut().zip(&self.sum[first..]) {
            (0..3).for_each(|c| x[c] += scale * f64::from(sum[c]));
        }
    }
}

impl Update for Each {
    fn fill<T: Entry>(
        &mut self,
        pool: &Pool,
        (rows, blocks): (usize, &[[T; 9]]),
        own: impl Fn(usize) -> Own + Sync + Copy,
        scale: f64,
    ) {
        pool.pieces(&mut self.bands[..], 1, &|_, bands| {
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
