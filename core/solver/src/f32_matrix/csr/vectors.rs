//! Vectors in a solve with rows that do not lie alike ([`super`]).

use crate::lanes::{LANES, Lanes, Quad, Vectors, Work, load, store, three};

/// `r -= a y` of a band's rows, with what the band before gave to the first of them.
pub struct UpdateResidual<'a> {
    pub y: &'a [[Quad; LANES]],
    pub before: &'a [[Quad; LANES]],
    pub a: f32,
    pub r: &'a mut [Vectors],
}

impl Work for UpdateResidual<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let a = unit.load(&[self.a; LANES]);
        for (at, (r, y)) in self.r.iter_mut().zip(self.y).enumerate() {
            let mut taken = unit.planes(load(unit, y));
            if let Some(before) = self.before.get(at) {
                let before = unit.planes(load(unit, before));
                (0..3).for_each(|c| taken[c] = unit.add(taken[c], before[c]));
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
    pub p: &'a mut [[Quad; LANES]],
    pub sum: &'a mut [[Quad; LANES]],
}

impl Work for UpdateDirection<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let (a, beta) = (unit.load(&[self.a; LANES]), unit.load(&[self.beta; LANES]));
        for ((p, sum), h) in self.p.iter_mut().zip(self.sum).zip(self.h) {
            let (mut turned, mut gone, h) = (load(unit, p), load(unit, sum), unit.vectors(three(unit, h)));
            for k in 0..4 {
                gone[k] = unit.fma(a, turned[k], gone[k]);
                turned[k] = unit.flush_denormals(unit.fma(beta, turned[k], h[k]));
            }
            store(unit, sum, gone);
            store(unit, p, turned);
        }
    }
}
