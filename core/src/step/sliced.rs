//! A product with rows that lie alike, sixteen at a time.
//!
//! On a regular mesh the neighbours of consecutive nodes are consecutive too: a slice of sixteen rows has its blocks at a few
//! distances from the diagonal. Then a lane of a vector unit is a row, nothing has to be gathered, and a block is read once for
//! both of the rows it joins (sliced ELLPACK: Kreutzer et al. 2014, with the distances in the place of columns). Lanes never meet,
//! so every vector unit gives the same bytes; bands of rows are added up in one order, so does any number of threads.

use super::lanes::widest;
use super::matrix::Rows;
use super::pool::Pool;
use super::single::{Quad, SingleBlock};
use super::sliced_product::{Multiply, Spread, Take};

/// Rows of a slice.
pub const LANES: usize = 16;
/// Numbers of a slice's blocks at one distance.
const BLOCKS: usize = 9 * LANES;
/// Rows of a band, at least.
const BAND: usize = 512;
/// What slices may hold for a block of the matrix: past this they read more than they save.
const FULLEST: f64 = 1.3;

/// Blocks of a matrix with rows that lie alike.
#[derive(Debug)]
pub struct Sliced {
    /// Rows of all bands but the last.
    height: usize,
    bands: Vec<Band>,
}

/// Rows that are multiplied by one thread.
#[derive(Debug)]
pub struct Band {
    pub first: usize,
    /// Of each slice's distances (slices + 1).
    pub start: Vec<usize>,
    /// Distances above the diagonal, rising.
    pub distance: Vec<u32>,
    /// By slice: blocks of the diagonal, then those of each distance (9 x 16).
    pub values: Vec<f32>,
    /// Of its rows and what they reach, by component.
    pub x: [Vec<f32>; 3],
    pub y: [Vec<f32>; 3],
    /// `x . y`
    pub dot: f64,
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
        // What a band gives to rows past its end belongs to the next one.
        let height = BAND.max((reach + LANES).next_multiple_of(BAND / 2));
        let bands = slices.chunks(height / LANES).enumerate().map(|(at, slices)| Band::new(at * height, slices, reach));
        Some(Self { height, bands: bands.collect() })
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.bands.iter().map(|b| 4 * (b.values.len() + b.distance.len() + 6 * b.x[0].len()) + 8 * b.start.len()).sum()
    }

    /// Rows of all bands but the last.
    pub fn height(&self) -> usize {
        self.height
    }

    /// To be given new values.
    pub fn bands_mut(&mut self) -> &mut [Band] {
        &mut self.bands
    }

    /// Finds `A x`, for [`Sliced::take`]; gives `x . A x`.
    pub fn product(&mut self, pool: &Pool, x: &[Quad]) -> f64 {
        pool.pieces(&mut self.bands[..], 1, &|_, bands| {
            for band in bands {
                pulp::Arch::new().dispatch(Spread { band, x });
                widest(Multiply(band));
            }
        });
        self.bands.iter().map(|band| band.dot).sum()
    }

    /// `r -= a A x`, rows `first` on.
    pub fn take(&self, first: usize, a: f32, r: &mut [Quad]) {
        let (mut at, mut rest) = (first, r);
        while !rest.is_empty() {
            let (band, row) = (at / self.height, at % self.height);
            let (r, more) = rest.split_at_mut(rest.len().min(self.height - row));
            let before = band.checked_sub(1).map(|before| &self.bands[before].y);
            // What the band before gave to its first rows.
            let before = before.map(|y| y.each_ref().map(|y| y.get(self.height + row..).unwrap_or_default()));
            let y = self.bands[band].y.each_ref().map(|y| &y[row..]);
            at += r.len();
            pulp::Arch::new().dispatch(Take { y, before: before.unwrap_or_default(), a, r });
            rest = more;
        }
    }
}

impl Band {
    fn new(first: usize, slices: &[Vec<u32>], reach: usize) -> Self {
        let mut start = vec![0];
        start.extend(slices.iter().scan(0, |end, slice| {
            *end += slice.len();
            Some(*end)
        }));
        let distance = slices.concat();
        let values = vec![0.0; BLOCKS * (slices.len() + distance.len())];
        let plane = || vec![0.0; LANES * slices.len() + reach];
        let planes = || [(); 3].map(|()| plane());
        Self { first, start, distance, values, x: planes(), y: planes(), dot: 0.0 }
    }

    /// Takes over new values: blocks from a slot on, and those of the diagonal, both of its rows alone.
    pub fn update(&mut self, rows: Rows<'_>, (slot, values): (usize, &[SingleBlock]), own: &[SingleBlock]) {
        for slice in 0..self.start.len() - 1 {
            let distances = &self.distance[self.start[slice]..self.start[slice + 1]];
            let to = &mut self.values[BLOCKS * (self.start[slice] + slice)..][..BLOCKS * (1 + distances.len())];
            for (lane, own) in own[LANES * slice..].iter().take(LANES).enumerate() {
                (0..9).for_each(|e| to[LANES * e + lane] = own[e]);
                let i = self.first + LANES * slice + lane;
                let (_, above, columns) = rows.around(i);
                let mut at = 0;
                for (block, j) in values[above - slot..].iter().zip(columns) {
                    while distances[at] != j - i as u32 {
                        at += 1;
                    }
                    let to = &mut to[BLOCKS * (1 + at)..][..BLOCKS];
                    (0..9).for_each(|e| to[LANES * e + lane] = block[e]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::lanes::{Plain, Work};
    use super::super::matrix::Matrix;
    use super::super::single_product::{self, Blocks};
    use super::*;

    fn wave(i: usize) -> f32 {
        (1.7 * i as f32).sin() * 10_f32.powi((i % 7) as i32 - 3)
    }

    /// Of a grid `n` wide with `rows` rows: neighbours across, up, and along both diagonals.
    fn grid(n: usize, rows: usize) -> Matrix {
        let mut matrix = Matrix::default();
        matrix.set_pattern(n * rows, |pair| {
            for (i, column) in (0..n * rows).map(|i| (i, i % n)) {
                for (across, up) in [(1, 0), (-1, 1), (0, 1), (1, 1), (0, 2)] {
                    let (to, line) = (column as i32 + across, i / n + up);
                    if (0..n as i32).contains(&to) && line < rows {
                        pair(i as u32, (line * n) as u32 + to as u32);
                    }
                }
            }
        });
        matrix
    }

    #[test]
    fn the_product_is_that_of_the_rows_on_every_vector_unit_and_any_number_of_threads() {
        let matrix = grid(53, 45);
        let (n, rows) = (matrix.rows(), matrix.pattern());
        let values: Vec<SingleBlock> =
            (0..=matrix.blocks()).map(|b| std::array::from_fn(|e| wave(9 * b + e))).collect();
        let own: Vec<SingleBlock> = (0..=n).map(|i| std::array::from_fn(|e| wave(11 * i + e))).collect();
        let x: Vec<Quad> = (0..n).map(|j| [wave(3 * j + 1), wave(3 * j + 2), wave(3 * j + 3), 0.0]).collect();
        let mut sliced = Sliced::new(n, rows).expect("rows of a grid lie alike");
        assert!(sliced.bands.len() > 2 && sliced.bytes() > 36 * matrix.blocks());
        let mut out = vec![vec![[1.0; 4]; n]; 2];
        let sums = [1, 3].map(|threads| {
            let pool = Pool::new(threads);
            for band in &mut sliced.bands {
                let rows_of = band.first..n.min(band.first + sliced.height);
                let slots = rows.slots(rows_of.clone());
                band.update(rows, (slots.start, &values[slots]), &own[rows_of]);
            }
            let sum = sliced.product(&pool, &x);
            let out = &mut out[threads / 2];
            out.fill([0.0; 4]);
            let (low, high) = out.split_at_mut(n / 3);
            sliced.take(0, -1.0, low);
            sliced.take(n / 3, -1.0, high);
            sum
        });
        let bits = |out: &[Quad]| out.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!((sums[0].to_bits(), bits(&out[0])), (sums[1].to_bits(), bits(&out[1])));
        let (before, dot) = (sliced.bands[1].y.concat(), sliced.bands[1].dot.to_bits());
        let before: Vec<_> = before.iter().map(|v| v.to_bits()).collect();
        let mut again = |multiply: &dyn Fn(Multiply<'_>)| {
            sliced.bands[1].y.iter_mut().for_each(|y| y.fill(0.0));
            multiply(Multiply(&mut sliced.bands[1]));
            assert_eq!(before, sliced.bands[1].y.concat().iter().map(|v| v.to_bits()).collect::<Vec<_>>());
            assert_eq!(dot, sliced.bands[1].dot.to_bits());
        };
        again(&|multiply| multiply.on(Plain));
        #[cfg(target_arch = "x86_64")]
        if let Some(unit) = pulp::x86::V3::try_new() {
            again(&|multiply| multiply.on(unit));
        }
        let mut other = vec![[0.0; 4]; n];
        let blocks = Blocks { values: values.as_flattened(), own: own.as_flattened(), rows };
        let sum = single_product::rows_product(0, &mut other, &x, blocks);
        let most = other.iter().flatten().fold(0.0_f32, |most, v| most.max(v.abs()));
        for (a, b) in out[0].iter().flatten().zip(other.iter().flatten()) {
            assert!((a - b).abs() < 1e-5 * most, "{a} {b}");
        }
        assert!((sums[0] - sum).abs() < 1e-4 * sum.abs(), "{} {sum}", sums[0]);
    }

    #[test]
    fn rows_that_do_not_lie_alike_are_left_to_others() {
        let mut matrix = Matrix::default();
        matrix.set_pattern(300, |pair| {
            (0..290_u32).for_each(|i| (1..5).for_each(|k| pair(i, i + 1 + (i * k * 7919) % (299 - i).min(97))));
        });
        assert!(Sliced::new(300, matrix.pattern()).is_none());
        assert!(Sliced::new(0, Matrix::default().pattern()).is_none());
    }
}
