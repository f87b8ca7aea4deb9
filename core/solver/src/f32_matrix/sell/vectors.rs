//! Vector updates of the iteration on regular patterns ([`super`]).

use crate::lanes::{self, LANES, Lanes, Sixteen, Vectors, Work};

/// `r -= a (y + before)` for rows of a band, by sixteen.
pub struct UpdateResidual<'a> {
    /// Product of the band, by component.
    pub y: [&'a [f32]; 3],
    /// What the previous band adds to the first rows, by component.
    pub before: [&'a [f32]; 3],
    /// Step of conjugate gradients along the direction, 1.
    pub a: f32,
    /// Residual of the rows, sixteen nodes each.
    pub r: &'a mut [Vectors],
}

impl Work for UpdateResidual<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Self { y, before, a, r } = self;
        let a = unit.load(&[a; LANES]);
        let overlap = (before[0].len() / LANES).min(r.len());
        for (at, r) in r.iter_mut().enumerate() {
            let mut product = three(unit, y, at);
            if at < overlap {
                let before = three(unit, before, at);
                for c in 0..3 {
                    product[c] = unit.add(product[c], before[c]);
                }
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
    /// Search direction, by component.
    pub p: [&'a mut [Sixteen]; 3],
    /// Sum of steps.
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

/// The sixteen vectors with number `at`.
#[inline(always)]
fn three<U: Lanes>(unit: U, of: [&[f32]; 3], at: usize) -> [U::V; 3] {
    let [a, b, c] = of;
    [sixteen(unit, a, at), sixteen(unit, b, at), sixteen(unit, c, at)]
}

/// The sixteen numbers with number `at`.
#[inline(always)]
fn sixteen<U: Lanes>(unit: U, of: &[f32], at: usize) -> U::V {
    unit.load(&of.as_chunks().0[at])
}
