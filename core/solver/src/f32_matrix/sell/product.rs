//! The loop of a product on regular patterns ([`super`]).

use super::{Band, prefetch_ahead};
use crate::lanes::{LANES, Lanes, Sixteen, Work};

/// Sixteen vectors in registers, by component.
pub type Three<U> = [<U as Lanes>::V; 3];

/// Multiplies the rows of a band by the search direction.
pub struct Multiply<'a> {
    /// Rows that are multiplied, with the product they get.
    pub band: &'a mut Band,
    /// Search direction of all nodes, by component.
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
        let (reached, values) = (*first..*first + y[0].len(), values.flat());
        let x = [&self.p[0][reached.clone()], &self.p[1][reached.clone()], &self.p[2][reached]];
        let mut dots = unit.load(&[0.0; LANES]);
        let mut blocks = values.as_chunks::<LANES>().0.chunks_exact(9);
        for (slice, ends) in start.windows(2).enumerate() {
            let at = LANES * slice;
            let own = three(unit, x, at);
            let mut sum = diagonal.times(unit, slice, own);
            for (distance, block) in distance[ends[0]..ends[1]].iter().zip(&mut blocks) {
                prefetch_ahead(block.as_flattened());
                let column = at + *distance as usize;
                let [a, b, c] = three(unit, x, column);
                let difference = [unit.sub(a, own[0]), unit.sub(b, own[1]), unit.sub(c, own[2])];
                add(unit, block, DIRECT, difference, &mut sum);
                // The block below the diagonal is the transpose, and its difference the negative.
                let mut other = three(unit, [&*y[0], &*y[1], &*y[2]], column);
                subtract(unit, block, TRANSPOSED, difference, &mut other);
                put(unit, &mut y, column, other);
            }
            let [a, b, c] = three(unit, [&*y[0], &*y[1], &*y[2]], at);
            // All earlier rows have been added to these.
            let [a, b, c] = [unit.add(a, sum[0]), unit.add(b, sum[1]), unit.add(c, sum[2])];
            put(unit, &mut y, at, [a, b, c]);
            dots = unit.fma(own[0], a, dots);
            dots = unit.fma(own[1], b, dots);
            dots = unit.fma(own[2], c, dots);
        }
        let end = LANES * (start.len() - 1);
        *dot = total(&unit.store(dots)) + (0..3).map(|c| dot_product(&x[c][end..], &y[c][end..])).sum::<f64>();
    }
}

/// `a . b`.
#[inline(always)]
fn dot_product(a: &[f32], b: &[f32]) -> f64 {
    let ((a, rest), (b, others)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sum = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sum[lane] += a[lane] * b[lane];
        }
    }
    rest.iter().zip(others).fold(total(&sum), |sum, (a, b)| sum + f64::from(a * b))
}

/// Sum of sixteen numbers, in double precision.
fn total(lanes: &Sixteen) -> f64 {
    lanes.iter().map(|v| f64::from(*v)).sum()
}

/// Sixteen vectors from element `at` on.
#[inline(always)]
fn three<U: Lanes>(unit: U, of: [&[f32]; 3], at: usize) -> Three<U> {
    let [a, b, c] = of;
    [sixteen(unit, a, at), sixteen(unit, b, at), sixteen(unit, c, at)]
}

/// Sixteen numbers from element `at` on.
#[inline(always)]
fn sixteen<U: Lanes>(unit: U, of: &[f32], at: usize) -> U::V {
    unit.load(of[at..].first_chunk().expect("planes reach as far as their distances"))
}

/// Stores sixteen vectors from element `at` on.
#[inline(always)]
fn put<U: Lanes>(unit: U, to: &mut [&mut [f32]; 3], at: usize, [a, b, c]: Three<U>) {
    to[0][at..at + LANES].copy_from_slice(&unit.store(a));
    to[1][at..at + LANES].copy_from_slice(&unit.store(b));
    to[2][at..at + LANES].copy_from_slice(&unit.store(c));
}

/// Order of the entries of a block.
pub const DIRECT: [usize; 9] = [0, 1, 2, 3, 4, 5, 6, 7, 8];
/// Order of the entries of its transpose.
pub const TRANSPOSED: [usize; 9] = [0, 3, 6, 1, 4, 7, 2, 5, 8];

/// Adds `block v` in each lane, with the entries of the block in the given order: `DIRECT` or `TRANSPOSED`.
#[inline(always)]
pub fn add<U: Lanes>(unit: U, block: &[Sixteen], order: [usize; 9], v: Three<U>, to: &mut Three<U>) {
    for row in 0..3 {
        for c in 0..3 {
            to[row] = unit.fma(unit.load(&block[order[3 * row + c]]), v[c], to[row]);
        }
    }
}

/// Subtracts `block v` in each lane, as [`add`] adds it.
#[inline(always)]
pub fn subtract<U: Lanes>(unit: U, block: &[Sixteen], order: [usize; 9], v: Three<U>, from: &mut Three<U>) {
    for row in 0..3 {
        for c in 0..3 {
            from[row] = unit.fnma(unit.load(&block[order[3 * row + c]]), v[c], from[row]);
        }
    }
}
