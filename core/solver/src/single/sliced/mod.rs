//! A product with rows that lie alike, sixteen at a time.
//!
//! On a regular mesh the neighbours of consecutive nodes are consecutive too: a slice of sixteen rows has its blocks at a few
//! distances from the diagonal. Then a lane of a vector unit is a row, nothing has to be gathered, and a block is read once for
//! both of the rows it joins (sliced ELLPACK: Kreutzer et al. 2014, with the distances in the place of columns). Lanes never meet,
//! so every vector unit gives the same bytes; bands of rows are added up in one order, so does any number of threads.

pub mod diagonal;
mod exact;
pub mod product;
#[cfg(test)]
mod tests;
pub mod update;
mod vectors;

use crate::algebra::Vec3;
use crate::lanes::aligned::Lines;
use crate::lanes::{Entry, LANES, Vectors, widest};
use crate::matrix::rounded::Own;
use crate::matrix::rows::Rows;
use crate::threads::Pool;
use diagonal::Diagonal;
use exact::Exact;
use pliant_plugin_api::prefetch;
use product::Multiply;
use update::{Fill, NONE, Slots, Update};
use vectors::{Take, Turn};

/// Numbers of a slice's blocks at one distance.
pub const BLOCKS: usize = 9 * LANES;
/// Slices in a piece of a vector for a thread.
const PIECE: usize = 128;
/// Rows of a band, at least.
const BAND: usize = 512;
/// Bands that are worth another thread in a product.
pub const BANDS: usize = 2;
/// What slices may hold for a block of the matrix: past this they read more than they save. With AVX-512 solves at 1.4 to 1.7 take 0.65
/// to 1 of the time of those that go block by block, with AVX2 as long; at 4.2 to 4.7 they take 1.4 to 1.5 of it.
const FULLEST: f64 = 1.8;

/// Distances of slices ahead that memory is asked for, two pages of values.
const AHEAD: usize = 16;

/// Asks memory for the blocks that come so much later than those `values` begin with.
#[inline(always)]
fn ask_ahead(values: &[f32]) {
    for e in 0..9 {
        prefetch(values, BLOCKS * AHEAD + LANES * e);
    }
}

/// Rows of a band where they reach so far: what one gives to rows past its end belongs to the next.
pub fn height(reach: usize) -> usize {
    BAND.max((reach + LANES).next_multiple_of(BAND / 2))
}

/// Blocks of a matrix with rows that lie alike, and the vectors that are multiplied with it.
#[derive(Debug)]
pub struct Sliced {
    /// Rows of all bands but the last.
    height: usize,
    bands: Vec<Band>,
    /// The direction of descent, by component, as far as the rows reach.
    p: [Lines<f32>; 3],
    /// How far it has gone in all, by slice and component.
    sum: Lines<f32>,
}

/// Rows that are multiplied by one thread.
#[derive(Debug)]
pub struct Band {
    pub first: usize,
    /// Of each slice's distances (slices + 1).
    pub start: Vec<usize>,
    /// Distances above the diagonal, rising, and which blocks are there.
    pub distance: Vec<u32>,
    slots: Vec<Slots>,
    /// By slice and distance (9 x 16).
    pub values: Lines<f32>,
    pub diagonal: Diagonal,
    /// Of its rows and what they reach, by component.
    pub y: [Lines<f32>; 3],
    /// `p . y`
    pub dot: f64,
    exact: Exact,
}

impl Sliced {
    /// For a pattern; `None` where its rows do not lie alike.
    pub fn new(n: usize, rows: Rows<'_>) -> Option<Self> {
        let (mut slices, mut room, mut blocks, mut reach) = (Vec::new(), n, n, 0);
        for first in (0..n).step_by(LANES) {
            let mut distances: Vec<u32> = Vec::new();
            for i in first..n.min(first + LANES) {
                let (_, _, columns) = rows.around(i);
                blocks += columns.len();
                distances.extend(columns.iter().map(|j| j - i as u32));
            }
            distances.sort_unstable();
            distances.dedup();
            room += LANES * distances.len();
            reach = distances.last().map_or(reach, |last| reach.max(*last as usize));
            slices.push(distances);
        }
        if n == 0 || room as f64 > FULLEST * blocks as f64 {
            return None;
        }
        let height = height(reach);
        let bands = slices.chunks(height / LANES).enumerate();
        let bands = bands.map(|(at, slices)| Band::new(at * height, slices, reach, rows));
        let p = [(); 3].map(|()| Lines::new((LANES * slices.len() + reach).next_multiple_of(LANES)));
        Some(Self { height, bands: bands.collect(), p, sum: Lines::new(3 * LANES * slices.len()) })
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let vectors = 3 * self.p[0].bytes() + self.sum.bytes();
        let of = |b: &Band| {
            b.values.bytes()
                + b.diagonal.bytes()
                + 4 * (LANES + 1) * b.distance.len()
                + 3 * b.y[0].bytes()
                + 8 * b.start.len()
                + b.exact.bytes()
        };
        vectors + self.bands.iter().map(of).sum::<usize>()
    }

    /// `p = 0`, and nothing gone.
    pub fn start(&mut self) {
        self.p.iter_mut().for_each(|p| p.flat_mut().fill(0.0));
        self.sum.flat_mut().fill(0.0);
    }

    /// Finds `A p`, for [`Sliced::take`]; gives `p . A p`.
    pub fn product(&mut self, pool: &Pool) -> f64 {
        let p = self.p.each_ref().map(Lines::flat);
        pool.pieces(&mut self.bands[..], BANDS, &|_, bands| {
            bands.iter_mut().for_each(|band| widest(Multiply { band, p }));
        });
        self.bands.iter().map(|band| band.dot).sum()
    }

    /// `r -= a A p`, slices `first` on.
    pub fn take(&self, first: usize, a: f32, r: &mut [Vectors]) {
        let (mut at, mut rest) = (LANES * first, r);
        while !rest.is_empty() {
            let (band, row) = (at / self.height, at % self.height);
            let (r, more) = rest.split_at_mut(rest.len().min((self.height - row) / LANES));
            // What the band before gave to its first rows.
            let before = band.checked_sub(1).map(|before| &self.bands[before].y);
            let before = before.map(|y| y.each_ref().map(|y| y.flat().get(self.height + row..).unwrap_or_default()));
            let y = self.bands[band].y.each_ref().map(|y| &y.flat()[row..]);
            at += LANES * r.len();
            widest(Take { y, before: before.unwrap_or_default(), a, r });
            rest = more;
        }
    }

    /// Goes by `a`, then `p = h + beta p`.
    pub fn turn(&mut self, pool: &Pool, h: &[Vectors], a: f32, beta: f32) {
        let rows = LANES * h.len();
        let [p0, p1, p2] = self.p.each_mut().map(|p| p.flat_mut()[..rows].as_chunks_mut().0);
        let sum = self.sum.vectors_mut();
        pool.pieces(((p0, p1), (p2, sum)), PIECE, &|first, ((p0, p1), (p2, sum))| {
            widest(Turn { h: &h[first..], a, beta, p: [p0, p1, p2], sum });
        });
    }

    /// Adds `scale` times all that was gone to rows `first` on.
    pub fn add_to(&self, first: usize, scale: f64, x: &mut [Vec3]) {
        let sum = self.sum.vectors();
        for (i, x) in (first..).zip(x) {
            (0..3).for_each(|c| x[c] += scale * f64::from(sum[i / LANES][c][i % LANES]));
        }
    }
}

impl Update for Sliced {
    fn fill<T: Entry>(
        &mut self,
        pool: &Pool,
        (rows, blocks): (usize, &[[T; 9]]),
        own: impl Fn(usize) -> Own + Sync + Copy,
        scale: f64,
    ) {
        pool.pieces(&mut self.bands[..], 1, &|_, bands| {
            bands.iter_mut().for_each(|band| widest(band.fill((rows, blocks), own, scale)));
        });
    }
}

impl Band {
    fn new(first: usize, slices: &[Vec<u32>], reach: usize, rows: Rows<'_>) -> Self {
        let mut start = vec![0];
        start.extend(slices.iter().scan(0, |end, slice| {
            *end += slice.len();
            Some(*end)
        }));
        let distance = slices.concat();
        let slot = |i: usize, distance: u32| {
            let (_, above, columns) = (i < rows.count()).then(|| rows.around(i))?;
            columns.binary_search(&(i as u32 + distance)).ok().map(|at| (above + at) as u32)
        };
        let places = (first..).step_by(LANES).zip(slices);
        let places = places.flat_map(|(first, slice)| slice.iter().map(move |distance| (first, *distance)));
        let slots = places.map(|(first, distance)| {
            let mut slots = [NONE; LANES];
            (0..LANES).for_each(|lane| slots[lane] = slot(first + lane, distance).unwrap_or(NONE));
            slots
        });
        let values = Lines::new(BLOCKS * distance.len());
        let y = [(); 3].map(|()| Lines::new((LANES * slices.len() + reach).next_multiple_of(LANES)));
        let diagonal = Diagonal::new(slices.len());
        Self { first, start, slots: slots.collect(), distance, values, diagonal, y, dot: 0.0, exact: Exact::default() }
    }

    /// What takes over new values, of a matrix of so many rows.
    fn fill<'a, T: Entry, F: Fn(usize) -> Own>(
        &'a mut self,
        (rows, blocks): (usize, &'a [[T; 9]]),
        own: F,
        scale: f64,
    ) -> Fill<'a, T, F> {
        let Self { first, start, slots, values, diagonal, .. } = self;
        Fill { blocks, own, scale, first: *first, rows, start, slots, values: values.flat_mut(), diagonal }
    }
}
