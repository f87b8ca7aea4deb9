//! Regular patterns: a SELL-16 matrix (sliced ELLPACK) with distances from the diagonal in place of columns.
//!
//! On a regular mesh the neighbours of consecutive nodes are consecutive too: the blocks of a slice of sixteen rows lie at a few distances
//! from the diagonal. A lane of the vector unit is a row, and the vectors at a distance are consecutive, so nothing is gathered; a block is
//! read once for itself and for its transpose below the diagonal (sliced ELLPACK, Kreutzer et al. 2014, with distances in place of columns).
//! No operation combines lanes, so every vector unit gives the same bytes; bands of rows are added up in a fixed order, so any number of
//! threads does too.

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
use crate::matrix::pattern::Pattern;
use crate::threads::Pool;
use diagonal::Diagonal;
use exact::Exact;
use pliant_plugin_api::prefetch;
use product::Multiply;
use update::{Fill, NONE, Slots, Update};
use vectors::{UpdateDirection, UpdateResidual};

/// Entries of the blocks of a slice at one distance.
pub const BLOCKS: usize = 9 * LANES;
/// Slices in a chunk of a vector for a thread.
const CHUNK: usize = 128;
/// Fewest rows of a band.
const BAND: usize = 512;
/// Fewest bands per thread in a product.
pub const BANDS: usize = 2;
/// Largest ratio of stored blocks, with padding, to blocks of the matrix at which this format is chosen. Compared with column indices, solves
/// at ratios of 1.4 to 1.7 take 0.65 to 1 of the time with AVX-512 and the same time with AVX2; at 4.2 to 4.7 they take 1.4 to 1.5 of it.
const MAX_FILL: f64 = 1.8;

/// Number of distances by which memory is prefetched: two pages of values.
const AHEAD: usize = 16;

/// Prefetches the blocks [`AHEAD`] distances after `values`.
#[inline(always)]
fn prefetch_ahead(values: &[f32]) {
    for e in 0..9 {
        prefetch(values, BLOCKS * AHEAD + LANES * e);
    }
}

/// Number of rows of a band of a matrix whose blocks lie at most `reach` from the diagonal: large enough that a band adds to no other than
/// the next one.
pub fn band_height(reach: usize) -> usize {
    BAND.max((reach + LANES).next_multiple_of(BAND / 2))
}

/// A matrix with the search direction and the sum of steps of an iteration.
#[derive(Debug)]
pub struct SellDistances {
    /// Rows of each band; the last may have fewer.
    height: usize,
    bands: Vec<Band>,
    /// Search direction, by component, as far as the rows reach.
    p: [Lines<f32>; 3],
    /// Sum of steps, by slice and component.
    sum: Lines<f32>,
}

/// Consecutive rows that one thread multiplies.
#[derive(Debug)]
pub struct Band {
    /// The first row.
    pub first: usize,
    /// Where the distances of each slice begin (slices + 1).
    pub start: Vec<usize>,
    /// Distances above the diagonal, ascending within a slice.
    pub distance: Vec<u32>,
    /// Slots of the blocks at each distance.
    slots: Vec<Slots>,
    /// Entries of the blocks at each distance (9 x 16).
    pub values: Lines<f32>,
    /// Sum of the blocks of each row, which takes the place of its diagonal block.
    pub diagonal: Diagonal,
    /// Product, by component: of the rows of the band, and what its blocks below the diagonal add to later rows.
    pub y: [Lines<f32>; 3],
    /// `p . y`.
    pub dot: f64,
    /// Vectors of products in double precision.
    exact: Exact,
}

impl SellDistances {
    /// A matrix of `n` rows with this pattern; `None` if slices have so many distances that padding exceeds [`MAX_FILL`].
    pub fn new(n: usize, pattern: Pattern<'_>) -> Option<Self> {
        let (mut slices, mut stored, mut blocks, mut reach) = (Vec::new(), n, n, 0);
        for first in (0..n).step_by(LANES) {
            let mut distances: Vec<u32> = Vec::new();
            for i in first..n.min(first + LANES) {
                let columns = pattern.off_diagonal(i).columns;
                blocks += columns.len();
                distances.extend(columns.iter().map(|j| j - i as u32));
            }
            distances.sort_unstable();
            distances.dedup();
            stored += LANES * distances.len();
            reach = distances.last().map_or(reach, |last| reach.max(*last as usize));
            slices.push(distances);
        }
        if n == 0 || stored as f64 > MAX_FILL * blocks as f64 {
            return None;
        }
        let height = band_height(reach);
        let bands = slices.chunks(height / LANES).enumerate();
        let bands = bands.map(|(at, slices)| Band::new(at * height, slices, reach, pattern));
        let p = [(); 3].map(|()| Lines::new((LANES * slices.len() + reach).next_multiple_of(LANES)));
        Some(Self { height, bands: bands.collect(), p, sum: Lines::new(3 * LANES * slices.len()) })
    }

    /// Memory of the bands and vectors, bytes.
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

    /// Sets the search direction and the sum of steps to zero.
    pub fn start(&mut self) {
        self.p.iter_mut().for_each(|p| p.flat_mut().fill(0.0));
        self.sum.flat_mut().fill(0.0);
    }

    /// Computes `A p`, which [`SellDistances::update_residual`] uses. Returns `p . A p`.
    pub fn product(&mut self, pool: &Pool) -> f64 {
        let p = self.p.each_ref().map(Lines::flat);
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
            let before = band.checked_sub(1).map(|before| &self.bands[before].y);
            let before = before.map(|y| y.each_ref().map(|y| y.flat().get(self.height + row..).unwrap_or_default()));
            let y = self.bands[band].y.each_ref().map(|y| &y.flat()[row..]);
            at += LANES * r.len();
            widest(UpdateResidual { y, before: before.unwrap_or_default(), a, r });
            rest = later;
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

    /// Adds `scale` times the sum of steps to `x`, whose first row is `first`.
    pub fn add_to(&self, first: usize, scale: f64, x: &mut [Vec3]) {
        let sum = self.sum.vectors();
        for (i, x) in (first..).zip(x) {
            (0..3).for_each(|c| x[c] += scale * f64::from(sum[i / LANES][c][i % LANES]));
        }
    }
}

impl Update for SellDistances {
    fn fill<T: Entry>(
        &mut self,
        pool: &Pool,
        rows: usize,
        blocks: &[[T; 9]],
        row_sum: impl Fn(usize) -> RowSum + Sync + Copy,
        scale: f64,
    ) {
        pool.par_chunks(&mut self.bands[..], 1, &|_, bands| {
            bands.iter_mut().for_each(|band| widest(band.fill(rows, blocks, row_sum, scale)));
        });
    }
}

impl Band {
    /// A band that begins at row `first` and has the given distances in each slice.
    fn new(first: usize, slices: &[Vec<u32>], reach: usize, pattern: Pattern<'_>) -> Self {
        let mut start = vec![0];
        start.extend(slices.iter().scan(0, |end, slice| {
            *end += slice.len();
            Some(*end)
        }));
        let distance = slices.concat();
        let slot = |i: usize, distance: u32| {
            let row = (i < pattern.count()).then(|| pattern.off_diagonal(i))?;
            row.columns.binary_search(&(i as u32 + distance)).ok().map(|at| (row.first_slot + at) as u32)
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

    /// The loop that loads the values of a matrix of `rows` rows into the band.
    fn fill<'a, T: Entry, F: Fn(usize) -> RowSum>(
        &'a mut self,
        rows: usize,
        blocks: &'a [[T; 9]],
        row_sum: F,
        scale: f64,
    ) -> Fill<'a, T, F> {
        let Self { first, start, slots, values, diagonal, .. } = self;
        Fill { blocks, row_sum, scale, first: *first, rows, start, slots, values: values.flat_mut(), diagonal }
    }
}
