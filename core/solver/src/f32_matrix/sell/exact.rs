//! Products in double precision with blocks in single precision, on regular patterns ([`super`]).

use super::{BLOCKS, Band, SellDistances, prefetch_ahead};
use crate::algebra::{Vec3, matrix3};
use crate::lanes::{LANES, Lanes, Work, widest};
use crate::matrix::f32_blocks::F32Blocks;
use crate::threads::{NODES, Pool};

/// Rows that are multiplied together: as many as the widest vector unit holds in double precision.
const HALF: usize = 8;

/// Vectors of a band for up to two products at once.
#[derive(Debug, Default)]
pub struct Exact([Planes; 2]);

/// Vectors of one product by component, of the rows of a band and those its blocks reach.
#[derive(Debug, Default)]
struct Planes {
    /// The vector that is multiplied.
    x: [Vec<f64>; 3],
    /// Product for each row, by component.
    y: [Vec<f64>; 3],
}

impl Exact {
    /// Memory of the two vectors, bytes.
    pub fn bytes(&self) -> usize {
        self.0.iter().map(|of| 8 * 6 * of.x[0].len()).sum()
    }
}

impl SellDistances {
    /// `out[k] = A x[k]`. `matrix` must be the one that was loaded last, and `unscale` the inverse of the scale it was loaded with.
    pub fn exact_products<const K: usize>(
        &mut self,
        pool: &Pool,
        matrix: &F32Blocks,
        unscale: f64,
        x: [&[Vec3]; K],
        out: [&mut [Vec3]; K],
    ) {
        pool.par_chunks(&mut self.bands[..], 1, &|_, bands| {
            bands.iter_mut().for_each(|band| widest(Multiply { band, x }));
        });
        let (bands, height) = (&self.bands[..], self.height);
        for (k, out) in out.into_iter().enumerate() {
            pool.par_chunks(out, NODES, &|first, out: &mut [Vec3]| {
                collect_rows(bands, height, k, first, out);
                for ((out, x), mass) in out.iter_mut().zip(&x[k][first..]).zip(&matrix.mass()[first..]) {
                    (0..3).for_each(|c| out[c] = mass * x[c] + unscale * out[c]);
                }
                for tool in matrix.tools() {
                    let node = tool.node as usize;
                    if let Some(out) = node.checked_sub(first).and_then(|at| out.get_mut(at)) {
                        *out += matrix3(&tool.block) * x[k][node];
                    }
                }
            });
        }
    }
}

/// Collects rows `first` on of product k from the bands, which have `height` rows each.
pub fn collect_rows(bands: &[Band], height: usize, k: usize, first: usize, out: &mut [Vec3]) {
    let (mut at, mut rest) = (first, out);
    while !rest.is_empty() {
        let (band, row) = (at / height, at % height);
        let (out, later) = rest.split_at_mut(rest.len().min(height - row));
        let y = &bands[band].exact.0[k].y;
        for (i, out) in (row..).zip(&mut *out) {
            *out = Vec3::new(y[0][i], y[1][i], y[2][i]);
        }
        // What the blocks of the previous band add to the first rows of this one.
        if let Some(before) = band.checked_sub(1) {
            let y = &bands[before].exact.0[k].y;
            for (i, out) in (height + row..y[0].len()).zip(&mut *out) {
                (0..3).for_each(|c| out[c] += y[c][i]);
            }
        }
        (at, rest) = (at + out.len(), later);
    }
}

/// Computes `sum_j A_ij (x_j - x_i)` for the rows of a band and up to two vectors x.
pub struct Multiply<'a, const K: usize> {
    /// Rows that are multiplied, with the products they get.
    pub band: &'a mut Band,
    /// Vectors of all nodes.
    pub x: [&'a [Vec3]; K],
}

impl<const K: usize> Work for Multiply<'_, K> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { band: Band { first, start, distance, values, y, exact, .. }, x: of } = self;
        let reach = y[0].flat().len();
        for (k, planes) in exact.0.iter_mut().enumerate().take(K) {
            planes.start(&of[k][*first..], reach);
        }
        let mut blocks = values.flat().as_chunks::<BLOCKS>().0;
        for (slice, ends) in start.windows(2).enumerate() {
            let (places, rest) = blocks.split_at(ends[1] - ends[0]);
            blocks = rest;
            // Half slices on all vector units, so that the order of additions is the same.
            for half in (0..LANES).step_by(HALF) {
                let at = LANES * slice + half;
                let mut sums = [[[unit.load_exact(&[0.0; HALF]); 3]; HALF]; K];
                for (distance, block) in distance[ends[0]..ends[1]].iter().zip(places) {
                    // The second half reads the same blocks.
                    if half == 0 {
                        prefetch_ahead(block);
                    }
                    for (part, lane) in (0..HALF).step_by(lanes(unit)).enumerate() {
                        let mut entries = [unit.exact(&block[half + lane..]); 9];
                        for e in 1..9 {
                            entries[e] = unit.exact(&block[LANES * e + half + lane..]);
                        }
                        for k in 0..K {
                            let row = at + lane;
                            let column = row + *distance as usize;
                            sums[k][part] = add(unit, &entries, &mut exact.0[k], row, column, sums[k][part]);
                        }
                    }
                }
                // All earlier rows have been added to these.
                for k in 0..K {
                    for (part, lane) in (0..HALF).step_by(lanes(unit)).enumerate() {
                        for c in 0..3 {
                            let y = &mut exact.0[k].y[c][at + lane..];
                            let sum = unit.add_exact(unit.load_exact(y), sums[k][part][c]);
                            unit.store_exact(sum, y);
                        }
                    }
                }
            }
        }
    }
}

/// Numbers in double precision that a register of the unit holds.
fn lanes<U: Lanes>(_: U) -> usize {
    U::EXACT
}

impl Planes {
    /// Copies up to `len` of the vectors `of`, and sets the product to zero.
    #[inline(always)]
    fn start(&mut self, of: &[Vec3], len: usize) {
        for c in 0..3 {
            self.x[c].resize(len, 0.0);
            self.y[c].resize(len, 0.0);
            self.y[c].fill(0.0);
        }
        let [a, b, c] = &mut self.x;
        for (((a, b), c), v) in a.iter_mut().zip(b).zip(c).zip(of) {
            (*a, *b, *c) = (v.x, v.y, v.z);
        }
    }
}

/// Multiplies the blocks (row, column) of consecutive rows and columns from `row` and `column` on. Returns `sum` with the products of the
/// rows added; those of the transposes are added to the columns.
#[inline(always)]
fn add<U: Lanes>(
    unit: U,
    entries: &[U::D; 9],
    Planes { x: [x0, x1, x2], y: [y0, y1, y2] }: &mut Planes,
    row: usize,
    column: usize,
    mut sum: [U::D; 3],
) -> [U::D; 3] {
    let difference = [
        unit.sub_exact(unit.load_exact(&x0[column..]), unit.load_exact(&x0[row..])),
        unit.sub_exact(unit.load_exact(&x1[column..]), unit.load_exact(&x1[row..])),
        unit.sub_exact(unit.load_exact(&x2[column..]), unit.load_exact(&x2[row..])),
    ];
    let mut other = [unit.load_exact(&y0[column..]), unit.load_exact(&y1[column..]), unit.load_exact(&y2[column..])];
    for a in 0..3 {
        for b in 0..3 {
            let entry = entries[3 * a + b];
            sum[a] = unit.add_product(entry, difference[b], sum[a]);
            // The block below the diagonal is the transpose, and its difference the negative.
            other[b] = unit.take_product(entry, difference[a], other[b]);
        }
    }
    unit.store_exact(other[0], &mut y0[column..]);
    unit.store_exact(other[1], &mut y1[column..]);
    unit.store_exact(other[2], &mut y2[column..]);
    sum
}
