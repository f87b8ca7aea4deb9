//! Regular patterns: a SELL-16 matrix (sliced ELLPACK) with distances from the diagonal in place of columns.
//!
//! On a regular mesh the neighbours of consecutive nodes are consecutive too: a slice of sixteen rows has its blocks at a few
//! distances from the diagonal. Then a lane of a vector unit is a row, nothing has to be gathered, and a block is read once for
//! both of the rows it joins (sell ELLPACK: Kreutzer et al. 2014, with the distances in the place of columns). Lanes never meet,
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
use crate::matrix::f32_blocks::RowSum;
use crate::matrix::pattern::Rows;
use crate::threads::Pool;
use diagonal::Diagonal;
use exact::Exact;
use pliant_plugin_api::prefetch;
use product::Multiply;
use update::{Fill, NONE, Slots, Update};
use vectors::{UpdateDirection, UpdateResidual};

/// Numbers of a slice's blocks at one distance.
pub const BLOCKS: usize = 9 * LANES;
/// Slices in a chunk of a vector for a thread.
const CHUNK: usize = 128;
/// Fewest rows of a band.
const BAND: usize = 512;
/// Fewest bands per thread in a product.
pub const BANDS: usize = 2;
/// Most stored blocks per block of the matrix: above it padding costs more than it saves. With AVX-512 solves at 1.4 to 1.7 take 0.65
/// to 1 of the time of those that go block by block, with AVX2 as long; at 4.2 to 4.7 they take 1.4 to 1.5 of it.
const MAX_FILL: f64 = 1.8;

/// How many distances ahead memory is prefetched: two pages of values.
const AHEAD: usize = 16;

/// Prefetches the blocks [`AHEAD`] distances later than `values`.
#[inline(always)]
fn prefetch_ahead(values: &[f32]) {
    for e in 0..9 {
        prefetch(values, BLOCKS * AHEAD + LANES * e);
    }
}

/// Rows of a band whose rows reach so far: what a band adds past its end belongs to the next one.
pub fn height(reach: usize) -> usize {
    BAND.max((reach + LANES).next_multiple_of(BAND / 2))
}

/// Blocks of the matrix with the vectors of the iteration.
#[derive(Debug)]
pub struct SellMatrix {
    /// Rows of all bands but the last.
    height: usize,
    bands: Vec<Band>,
    /// Search direction, by component, as far as the rows reach.
    p: [Lines<f32>; 3],
    /// Sum of steps, by slice and component.
    sum: Lines<f32>,
}

/// Rows that are multiplied by one thread.
#[derive(Debug)]
pub struct Band {
    pub first: usize,
    /// Where the distances of each slice begin (slices + 1).
    pub start: Vec<usize>,
    /// Distances above the diagonal, ascending within a slice.
    pub distance: Vec<u32>,
    /// Slots of the blocks at each distance.
    slots: Vec<Slots>,
    /// Blocks by slice and distance (9 x 16).
    pub values: Lines<f32>,
    pub diagonal: Diagonal,
    /// Product of its rows and of those they reach, by component.
    pub y: [Lines<f32>; 3],
    /// `p . y`
    pub dot: f64,
    exact: Exact,
}

impl SellMatrix {
    /// A matrix of `n` rows with this pattern; `None` if its slices have too many distances.
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
        if n == 0 || room as f64 > MAX_FILL * blocks as f64 {
            return None;
        }
        let height = height(reach);
        let bands = slices.chunks(height / LANES).enumerate();
        let bands = bands.map(|(at, slices)| Band::new(at * height, slices, reach, rows));
        let p = [(); 3].map(|()| Lines::new((LANES * slices.len() + reach).next_multiple_of(LANES)));
        Some(Self { height, bands: bands.collect(), p, sum: Lines::new(3 * LANES * slices.len()) })
    }

    /// Memory, bytes.
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

    /// Sets direction and sum to zero.
    pub fn start(&mut self) {
        self.p.iter_mut().for_each(|p| p.flat_mut().fill(0.0));
        self.sum.flat_mut().fill(0.0);
    }

    /// Finds `A p`, for [`SellMatrix::take`]; gives `p . A p`.
    pub fn product(&mut self, pool: &Pool) -> f64 {
        let p = self.p.each_ref().map(Lines::flat);
        pool.par_chunks(&mut self.bands[..], BANDS, &|_, bands| {
            bands.iter_mut().for_each(|band| widest(Multiply { band, p }));
        });
        self.bands.iter().map(|band| band.dot).sum()
    }

    /// `r -= a A p`, slices `first` on.
    pub fn update_residual(&self, first: usize, a: f32, r: &mut [Vectors]) {
        let (mut at, mut rest) = (LANES * first, r);
        while !rest.is_empty() {
            let (band, row) = (at / self.height, at % self.height);
            let (r, more) = rest.split_at_mut(rest.len().min((self.height - row) / LANES));
            // What the previous band added to its first rows.
            let before = band.checked_sub(1).map(|before| &self.bands[before].y);
            let before = before.map(|y| y.each_ref().map(|y| y.flat().get(self.height + row..).unwrap_or_default()));
            let y = self.bands[band].y.each_ref().map(|y| &y.flat()[row..]);
            at += LANES * r.len();
            widest(UpdateResidual { y, before: before.unwrap_or_default(), a, r });
            rest = more;
        }
    }

    /// `sum += a p`, then `p = h + beta p`.
    pub fn update_direction(&mut self, pool: &Pool, h: &[Vectors], a: f32, beta: f32) {
        let rows = LANES * h.len();
        let [p0, p1, p2] = self.p.each_mut().map(|p| p.flat_mut()[..rows].as_chunks_mut().0);
        let sum = self.sum.vectors_mut();
        pool.par_chunks(((p0, p1), (p2, sum)), CHUNK, &|first, ((p0, p1), (p2, sum))| {
            widest(UpdateDirection { h: &h[first..], a, beta, p: [p0, p1, p2], sum });
        });
    }

    /// Adds `scale` times the sum of steps to rows `first` on.
    pub fn add_to(&self, first: usize, scale: f64, x: &mut [Vec3]) {
        let sum = self.sum.vectors();
        for (i, x) in (first..).zip(x) {
            (0..3).for_each(|c| x[c] += scale * f64::from(sum[i / LANES][c][i % LANES]));
        }
    }
}

impl Update for SellMatrix {
    fn fill<T: Entry>(
        &mut self,
        pool: &Pool,
        rows: usize,
        blocks: &[[T; 9]],
        own: impl Fn(usize) -> RowSum + Sync + Copy,
        scale: f64,
    ) {
        pool.par_chunks(&mut self.bands[..], 1, &|_, bands| {
            bands.iter_mut().for_each(|band| widest(band.fill(rows, blocks, own, scale)));
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
    fn fill<'a, T: Entry, F: Fn(usize) -> RowSum>(
        &'a mut self,
        rows: usize,
        blocks: &'a [[T; 9]],
        own: F,
        scale: f64,
    ) -> Fill<'a, T, F> {
        let Self { first, start, slots, values, diagonal, .. } = self;
        Fill { blocks, own, scale, first: *first, rows, start, slots, values: values.flat_mut(), diagonal }
    }
}
