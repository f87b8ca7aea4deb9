//! The hot loops of a product on regular patterns ([`super`]).

use super::{Band, prefetch_ahead};
use crate::lanes::{LANES, Lanes, Sixteen, Work};

/// Three rows of lanes.
pub type Three<U> = [<U as Lanes>::V; 3];

/// A band's share of the product with `p`, into its planes.
pub struct Multiply<'a> {
    pub band: &'a mut Band,
    pub p: [&'a [f32]; 3],
}

impl Work for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Band { first, start, distance, values, diagonal, y, dot, .. } = self.band;
        let [y0, y1, y2] = y;
        let mut y = [y0.flat_mut(), y1.flat_mut(), y2.flat_mut()];
        y.iter_mut().for_each(|y| y.fill(0.0));
        let (all, values) = (*first..*first + y[0].len(), values.flat());
        let x = [&self.p[0][all.clone()], &self.p[1][all.clone()], &self.p[2][all]];
        let mut all = unit.load(&[0.0; LANES]);
        let mut blocks = values.as_chunks::<LANES>().0.chunks_exact(9);
        for (slice, ends) in start.windows(2).enumerate() {
            let at = LANES * slice;
            let here = three(unit, x, at);
            let mut sum = diagonal.times(unit, slice, here);
            for (distance, block) in distance[ends[0]..ends[1]].iter().zip(&mut blocks) {
                prefetch_ahead(block.as_flattened());
                let there = at + *distance as usize;
                let [a, b, c] = three(unit, x, there);
                let away = [unit.sub(a, here[0]), unit.sub(b, here[1]), unit.sub(c, here[2])];
                add(unit, block, STRAIGHT, away, &mut sum);
                // The block below the diagonal: transposed, and from there to here.
                let mut other = three(unit, [&*y[0], &*y[1], &*y[2]], there);
                take(unit, block, TURNED, away, &mut other);
                put(unit, &mut y, there, other);
            }
            let [a, b, c] = three(unit, [&*y[0], &*y[1], &*y[2]], at);
            // Previous rows have added all they add to these.
            let [a, b, c] = [unit.add(a, sum[0]), unit.add(b, sum[1]), unit.add(c, sum[2])];
            put(unit, &mut y, at, [a, b, c]);
            all = unit.fma(here[0], a, all);
            all = unit.fma(here[1], b, all);
            all = unit.fma(here[2], c, all);
        }
        let past = LANES * (start.len() - 1);
        *dot = total(&unit.store(all)) + (0..3).map(|c| product(&x[c][past..], &y[c][past..])).sum::<f64>();
    }
}

/// `a . b`
#[inline(always)]
fn product(a: &[f32], b: &[f32]) -> f64 {
    let ((a, rest), (b, others)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sum = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sum[lane] += a[lane] * b[lane];
        }
    }
    rest.iter().zip(others).fold(total(&sum), |sum, (a, b)| sum + f64::from(a * b))
}

fn total(lanes: &Sixteen) -> f64 {
    lanes.iter().map(|v| f64::from(*v)).sum()
}

#[inline(always)]
fn three<U: Lanes>(unit: U, of: [&[f32]; 3], at: usize) -> Three<U> {
    let [a, b, c] = of;
    [sixteen(unit, a, at), sixteen(unit, b, at), sixteen(unit, c, at)]
}

#[inline(always)]
fn sixteen<U: Lanes>(unit: U, of: &[f32], at: usize) -> U::V {
    unit.load(of[at..].first_chunk().expect("planes reach as far as their distances"))
}

#[inline(always)]
fn put<U: Lanes>(unit: U, to: &mut [&mut [f32]; 3], at: usize, [a, b, c]: Three<U>) {
    to[0][at..at + LANES].copy_from_slice(&unit.store(a));
    to[1][at..at + LANES].copy_from_slice(&unit.store(b));
    to[2][at..at + LANES].copy_from_slice(&unit.store(c));
}

/// A block as it is, and transposed.
pub const STRAIGHT: [usize; 9] = [0, 1, 2, 3, 4, 5, 6, 7, 8];
pub const TURNED: [usize; 9] = [0, 3, 6, 1, 4, 7, 2, 5, 8];

/// Adds blocks, with their entries in an order, times a vector, in each lane.
#[inline(always)]
pub fn add<U: Lanes>(unit: U, block: &[Sixteen], order: [usize; 9], v: Three<U>, to: &mut Three<U>) {
    for row in 0..3 {
        for c in 0..3 {
            to[row] = unit.fma(unit.load(&block[order[3 * row + c]]), v[c], to[row]);
        }
    }
}

/// Subtracts the same.
#[inline(always)]
pub fn take<U: Lanes>(unit: U, block: &[Sixteen], order: [usize; 9], v: Three<U>, from: &mut Three<U>) {
    for row in 0..3 {
        for c in 0..3 {
            from[row] = unit.fnma(unit.load(&block[order[3 * row + c]]), v[c], from[row]);
        }
    }
}
