//! The hot loops of a product with rows that lie alike ([`super::sliced`]).

use super::lanes::{Lanes, Sixteen, Work};
use super::multilevel::plus;
use super::single::{Quad, without_dust};
use super::sliced::{Band, LANES};

/// Takes the vector of a band's rows apart; what it gives starts from nothing.
pub struct Spread<'a> {
    pub band: &'a mut Band,
    pub x: &'a [Quad],
}

impl pulp::NullaryFnOnce for Spread<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Band { first, x: [x0, x1, x2], y, .. } = self.band;
        let planes = x0.iter_mut().zip(x1).zip(x2);
        planes.zip(&self.x[*first..]).for_each(|(((x0, x1), x2), x)| (*x0, *x1, *x2) = (x[0], x[1], x[2]));
        y.iter_mut().for_each(|y| y.fill(0.0));
    }
}

/// Three rows of lanes.
type Three<U> = [<U as Lanes>::V; 3];

/// A band's share of the product, into its planes.
pub struct Multiply<'a>(pub &'a mut Band);

impl Work for Multiply<'_> {
    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Band { start, distance, values, x, y, dot, .. } = self.0;
        let x = [&x[0][..], &x[1][..], &x[2][..]];
        let [y0, y1, y2] = y;
        let mut y = [&mut y0[..], &mut y1[..], &mut y2[..]];
        let mut all = unit.load(&[0.0; LANES]);
        let mut blocks = values.as_chunks::<LANES>().0.chunks_exact(9);
        for (slice, ends) in start.windows(2).enumerate() {
            let at = LANES * slice;
            let here = three(unit, x, at);
            let own = blocks.next().expect("a slice has a diagonal");
            let mut sum = times(unit, own, [0, 1, 2, 3, 4, 5, 6, 7, 8], here);
            for (distance, block) in distance[ends[0]..ends[1]].iter().zip(&mut blocks) {
                let there = at + *distance as usize;
                let [a, b, c] = three(unit, x, there);
                let away = [unit.sub(a, here[0]), unit.sub(b, here[1]), unit.sub(c, here[2])];
                let [a, b, c] = times(unit, block, [0, 1, 2, 3, 4, 5, 6, 7, 8], away);
                sum = [unit.add(sum[0], a), unit.add(sum[1], b), unit.add(sum[2], c)];
                // The block below the diagonal: transposed, and from there to here.
                let [a, b, c] = times(unit, block, [0, 3, 6, 1, 4, 7, 2, 5, 8], away);
                let [d, e, f] = three(unit, [&*y[0], &*y[1], &*y[2]], there);
                put(unit, &mut y, there, [unit.sub(d, a), unit.sub(e, b), unit.sub(f, c)]);
            }
            let [a, b, c] = three(unit, [&*y[0], &*y[1], &*y[2]], at);
            // Rows before have given all they give to these.
            let [a, b, c] = [unit.add(a, sum[0]), unit.add(b, sum[1]), unit.add(c, sum[2])];
            put(unit, &mut y, at, [a, b, c]);
            all = unit.add(all, unit.mul(here[0], a));
            all = unit.add(all, unit.mul(here[1], b));
            all = unit.add(all, unit.mul(here[2], c));
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

/// Blocks, with their entries in an order, times a vector, in each lane.
#[inline(always)]
fn times<U: Lanes>(unit: U, block: &[Sixteen], [a, b, c, d, e, f, g, h, i]: [usize; 9], v: Three<U>) -> Three<U> {
    [row(unit, block, [a, b, c], v), row(unit, block, [d, e, f], v), row(unit, block, [g, h, i], v)]
}

#[inline(always)]
fn row<U: Lanes>(unit: U, block: &[Sixteen], [a, b, c]: [usize; 3], [x, y, z]: Three<U>) -> U::V {
    let (a, b, c) = (unit.load(&block[a]), unit.load(&block[b]), unit.load(&block[c]));
    unit.add(unit.add(unit.mul(a, x), unit.mul(b, y)), unit.mul(c, z))
}

/// `r -= a y` of a band's rows, with what the band before gave to the first of them.
pub struct Take<'a> {
    pub y: [&'a [f32]; 3],
    pub before: [&'a [f32]; 3],
    pub a: f32,
    pub r: &'a mut [Quad],
}

impl pulp::NullaryFnOnce for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { y: [y0, y1, y2], before: [b0, b1, b2], a, r } = self;
        let both = b0.len().min(r.len());
        let (first, rest) = r.split_at_mut(both);
        for (i, r) in first.iter_mut().enumerate() {
            *r = without_dust(plus(*r, -a, [y0[i] + b0[i], y1[i] + b1[i], y2[i] + b2[i], 0.0]));
        }
        for (((r, y0), y1), y2) in rest.iter_mut().zip(&y0[both..]).zip(&y1[both..]).zip(&y2[both..]) {
            *r = without_dust(plus(*r, -a, [*y0, *y1, *y2, 0.0]));
        }
    }
}
