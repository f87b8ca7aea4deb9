//! Vectors in a solve with rows that do not lie alike ([`super`]).

use crate::step::single::{Quad, without_dust};

/// `a + s b`
#[inline(always)]
fn plus(a: Quad, s: f32, b: Quad) -> Quad {
    let mut out = a;
    for c in 0..4 {
        out[c] += s * b[c];
    }
    out
}

/// `r -= a y` of a band's rows, with what the band before gave to the first of them.
pub struct Take<'a> {
    pub y: &'a [Quad],
    pub before: &'a [Quad],
    pub a: f32,
    pub r: &'a mut [Quad],
}

impl pulp::NullaryFnOnce for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { y, before, a, r } = self;
        let (both, rest) = r.split_at_mut(before.len().min(r.len()));
        for ((r, y), before) in both.iter_mut().zip(y).zip(before) {
            *r = without_dust(plus(*r, -a, plus(*y, 1.0, *before)));
        }
        for (r, y) in rest.iter_mut().zip(&y[both.len()..]) {
            *r = without_dust(plus(*r, -a, *y));
        }
    }
}

/// `sum += a p`, then `p = h + beta p`.
pub struct Turn<'a> {
    pub h: &'a [Quad],
    pub a: f32,
    pub beta: f32,
    pub p: &'a mut [Quad],
    pub sum: &'a mut [Quad],
}

impl pulp::NullaryFnOnce for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { h, a, beta, p, sum } = self;
        for ((p, sum), h) in p.iter_mut().zip(sum).zip(h) {
            *sum = plus(*sum, a, *p);
            *p = without_dust(plus(*h, beta, *p));
        }
    }
}
