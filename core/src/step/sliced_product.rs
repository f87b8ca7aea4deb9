//! The hot loops of a product with rows that lie alike ([`super::sliced`]).

use super::lanes::{Lanes, Sixteen, Work};
use super::multilevel::dot;
use super::single::Quad;
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
        let Band { start, distance, values, x, y, .. } = self.0;
        let x = [&x[0][..], &x[1][..], &x[2][..]];
        let [y0, y1, y2] = y;
        let mut y = [&mut y0[..], &mut y1[..], &mut y2[..]];
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
            put(unit, &mut y, at, [unit.add(a, sum[0]), unit.add(b, sum[1]), unit.add(c, sum[2])]);
        }
    }
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

/// Rows of a band, with what the band before gave to them.
pub struct Join<'a> {
    pub y: &'a [Vec<f32>; 3],
    /// The first, in its band.
    pub row: usize,
    /// What the band before has, with `height` rows of its own.
    pub before: Option<&'a [Vec<f32>; 3]>,
    pub height: usize,
    pub x: &'a [Quad],
    pub out: &'a mut [Quad],
}

impl pulp::NullaryFnOnce for Join<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let [y0, y1, y2] = self.y;
        let (y0, y1, y2) = (&y0[self.row..], &y1[self.row..], &y2[self.row..]);
        for (((out, y0), y1), y2) in self.out.iter_mut().zip(y0).zip(y1).zip(y2) {
            *out = [*y0, *y1, *y2, 0.0];
        }
        if let Some(before) = self.before {
            let [y0, y1, y2] = before.each_ref().map(|y| y.get(self.height + self.row..).unwrap_or_default());
            for (((out, y0), y1), y2) in self.out.iter_mut().zip(y0).zip(y1).zip(y2) {
                (out[0], out[1], out[2]) = (out[0] + y0, out[1] + y1, out[2] + y2);
            }
        }
        dot(self.x, self.out)
    }
}
