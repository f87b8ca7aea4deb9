//! Vector updates of the iteration on irregular patterns ([`super`]).

use crate::lanes::{LANES, Lanes, Quad, Vectors, Work, load, store, three};

/// `r -= a (y + before)` for rows of a band, by sixteen.
pub struct UpdateResidual<'a> {
    /// Product of the band.
    pub y: &'a [[Quad; LANES]],
    /// What the previous band adds to the first rows.
    pub before: &'a [[Quad; LANES]],
    /// Step of conjugate gradients along the direction, 1.
    pub a: f32,
    /// Residual of the rows, sixteen nodes each.
    pub r: &'a mut [Vectors],
}

impl Work for UpdateResidual<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let a = unit.load(&[self.a; LANES]);
        for (at, (r, y)) in self.r.iter_mut().zip(self.y).enumerate() {
            let mut product = unit.planes(load(unit, y));
            if let Some(before) = self.before.get(at) {
                let before = unit.planes(load(unit, before));
                (0..3).for_each(|c| product[c] = unit.add(product[c], before[c]));
            }
            for (r, product) in r.iter_mut().zip(product) {
                *r = unit.store(unit.flush_denormals(unit.fnma(a, product, unit.load(r))));
            }
        }
    }
}

/// `sum += a p`, then `p = h + beta p`, by sixteen nodes.
pub struct UpdateDirection<'a> {
    /// Residual times the preconditioner, sixteen nodes each.
    pub h: &'a [Vectors],
    /// Length of the last step.
    pub a: f32,
    /// Factor of the last direction.
    pub beta: f32,
    /// Search direction of the iteration, for each node.
    pub p: &'a mut [[Quad; LANES]],
    /// Sum of steps.
    pub sum: &'a mut [[Quad; LANES]],
}

impl Work for UpdateDirection<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let (a, beta) = (unit.load(&[self.a; LANES]), unit.load(&[self.beta; LANES]));
        for ((p, sum), h) in self.p.iter_mut().zip(self.sum).zip(self.h) {
            let (mut direction, mut total, h) = (load(unit, p), load(unit, sum), unit.vectors(three(unit, h)));
            for k in 0..4 {
                total[k] = unit.fma(a, direction[k], total[k]);
                direction[k] = unit.flush_denormals(unit.fma(beta, direction[k], h[k]));
            }
            store(unit, sum, total);
            store(unit, p, direction);
        }
    }
}
