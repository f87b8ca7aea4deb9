//! Vectors in a solve on regular patterns ([`super`]): sixteen at a time, by component where they are multiplied.

use crate::lanes::{self, LANES, Lanes, Sixteen, Vectors, Work};

/// `r -= a y` of a band's rows, with what the band before gave to the first of them.
pub struct UpdateResidual<'a> {
    pub y: [&'a [f32]; 3],
    pub before: [&'a [f32]; 3],
    pub a: f32,
    pub r: &'a mut [Vectors],
}

impl Work for UpdateResidual<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { y, before, a, r } = self;
        let a = unit.load(&[a; LANES]);
        let both = (before[0].len() / LANES).min(r.len());
        for (at, r) in r.iter_mut().enumerate() {
            let mut taken = three(unit, y, at);
            if at < both {
                let before = three(unit, before, at);
                for c in 0..3 {
                    taken[c] = unit.add(taken[c], before[c]);
                }
            }
            for (r, taken) in r.iter_mut().zip(taken) {
                *r = unit.store(unit.flush_denormals(unit.fnma(a, taken, unit.load(r))));
            }
        }
    }
}

/// `sum += a p`, then `p = h + beta p`.
pub struct UpdateDirection<'a> {
    pub h: &'a [Vectors],
    pub a: f32,
    pub beta: f32,
    pub p: [&'a mut [Sixteen]; 3],
    pub sum: &'a mut [Vectors],
}

impl Work for UpdateDirection<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { h, a, beta, p: [p0, p1, p2], sum } = self;
        let (a, beta) = (unit.load(&[a; LANES]), unit.load(&[beta; LANES]));
        for ((((p0, p1), p2), sum), h) in p0.iter_mut().zip(p1).zip(p2).zip(sum).zip(h) {
            let (h, p) = (lanes::three(unit, h), [p0, p1, p2]);
            for c in 0..3 {
                let before = unit.load(p[c]);
                sum[c] = unit.store(unit.fma(a, before, unit.load(&sum[c])));
                *p[c] = unit.store(unit.flush_denormals(unit.fma(beta, before, h[c])));
            }
        }
    }
}

#[inline(always)]
fn three<U: Lanes>(unit: U, of: [&[f32]; 3], at: usize) -> [U::V; 3] {
    let [a, b, c] = of;
    [sixteen(unit, a, at), sixteen(unit, b, at), sixteen(unit, c, at)]
}

#[inline(always)]
fn sixteen<U: Lanes>(unit: U, of: &[f32], at: usize) -> U::V {
    unit.load(&of.as_chunks().0[at])
}
