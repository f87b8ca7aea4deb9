//! Products in double precision with blocks in single, of rows that lie alike ([`super`]).

use super::{BLOCKS, Band, SellMatrix, prefetch_ahead};
use crate::algebra::{Vec3, matrix3};
use crate::lanes::{LANES, Lanes, Work, widest};
use crate::matrix::f32_blocks::F32Blocks;
use crate::threads::{NODES, Pool};

/// Rows that are multiplied together: as many as the widest unit takes in double precision.
const HALF: usize = 8;

/// Vectors by component, of a band's rows and what they reach: what is multiplied, and what comes of it.
#[derive(Debug, Default)]
pub struct Exact([Planes; 2]);

#[derive(Debug, Default)]
struct Planes {
    x: [Vec<f64>; 3],
    y: [Vec<f64>; 3],
}

impl Exact {
    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        self.0.iter().map(|of| 8 * 6 * of.x[0].len()).sum()
    }
}

impl SellMatrix {
    /// `out[k] = A x[k]`, where `matrix` is what was taken over times a scale, whose inverse is `up`.
    pub fn exact_products<const K: usize>(
        &mut self,
        pool: &Pool,
        matrix: &F32Blocks,
        up: f64,
        x: [&[Vec3]; K],
        out: [&mut [Vec3]; K],
    ) {
        pool.par_chunks(&mut self.bands[..], 1, &|_, bands| {
            bands.iter_mut().for_each(|band| widest(Multiply { band, x }));
        });
        let (bands, height) = (&self.bands[..], self.height);
        for (k, out) in out.into_iter().enumerate() {
            pool.par_chunks(out, NODES, &|first, out: &mut [Vec3]| {
                rows(bands, height, k, first, out);
                for ((out, x), mass) in out.iter_mut().zip(&x[k][first..]).zip(&matrix.mass()[first..]) {
                    (0..3).for_each(|c| out[c] = mass * x[c] + up * out[c]);
                }
                for (i, block) in matrix.tools() {
                    if let Some(out) = (*i as usize).checked_sub(first).and_then(|at| out.get_mut(at)) {
                        *out += matrix3(block) * x[k][*i as usize];
                    }
                }
            });
        }
    }
}

/// What bands of a height have for rows `first` on of a product.
pub fn rows(bands: &[Band], height: usize, k: usize, first: usize, out: &mut [Vec3]) {
    let (mut at, mut rest) = (first, out);
    while !rest.is_empty() {
        let (band, row) = (at / height, at % height);
        let (out, more) = rest.split_at_mut(rest.len().min(height - row));
        let y = &bands[band].exact.0[k].y;
        for (i, out) in (row..).zip(&mut *out) {
            *out = Vec3::new(y[0][i], y[1][i], y[2][i]);
        }
        // What the previous band added to its first rows.
        if let Some(before) = band.checked_sub(1) {
            let y = &bands[before].exact.0[k].y;
            for (i, out) in (height + row..y[0].len()).zip(&mut *out) {
                (0..3).for_each(|c| out[c] += y[c][i]);
            }
        }
        (at, rest) = (at + out.len(), more);
    }
}

/// A band's share of the products of its blocks off the diagonal with differences.
pub struct Multiply<'a, const K: usize> {
    pub band: &'a mut Band,
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
            // Half by half, for all units: rows are given to in one order.
            for half in (0..LANES).step_by(HALF) {
                let at = LANES * slice + half;
                let mut here = [[[unit.load_exact(&[0.0; HALF]); 3]; HALF]; K];
                for (distance, block) in distance[ends[0]..ends[1]].iter().zip(places) {
                    // The other half reads the same blocks.
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
                            here[k][part] = add(unit, &entries, &mut exact.0[k], row, column, here[k][part]);
                        }
                    }
                }
                // Previous rows have added all they add to these.
                for k in 0..K {
                    for (part, lane) in (0..HALF).step_by(lanes(unit)).enumerate() {
                        for c in 0..3 {
                            let y = &mut exact.0[k].y[c][at + lane..];
                            let sum = unit.add_exact(unit.load_exact(y), here[k][part][c]);
                            unit.store_exact(sum, y);
                        }
                    }
                }
            }
        }
    }
}

fn lanes<U: Lanes>(_: U) -> usize {
    U::EXACT
}

impl Planes {
    /// Takes over vectors from their first row on, and zeros the result.
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

/// Adds what blocks between rows do: to those further on in memory, and to what these have so far.
#[inline(always)]
fn add<U: Lanes>(
    unit: U,
    entries: &[U::D; 9],
    Planes { x: [x0, x1, x2], y: [y0, y1, y2] }: &mut Planes,
    at: usize,
    there: usize,
    mut here: [U::D; 3],
) -> [U::D; 3] {
    let away = [
        unit.sub_exact(unit.load_exact(&x0[there..]), unit.load_exact(&x0[at..])),
        unit.sub_exact(unit.load_exact(&x1[there..]), unit.load_exact(&x1[at..])),
        unit.sub_exact(unit.load_exact(&x2[there..]), unit.load_exact(&x2[at..])),
    ];
    let mut other = [unit.load_exact(&y0[there..]), unit.load_exact(&y1[there..]), unit.load_exact(&y2[there..])];
    for row in 0..3 {
        for c in 0..3 {
            let entry = entries[3 * row + c];
            here[row] = unit.add_product(entry, away[c], here[row]);
            // The block below the diagonal: transposed, and from there to here.
            other[c] = unit.take_product(entry, away[row], other[c]);
        }
    }
    unit.store_exact(other[0], &mut y0[there..]);
    unit.store_exact(other[1], &mut y1[there..]);
    unit.store_exact(other[2], &mut y2[there..]);
    here
}
