//! The finest level of P: block Jacobi's share, and what comes from the coarser ones.

use crate::step::lanes::{Lanes, Sixteen, Vectors, Work, put, three};
use crate::step::sliced::LANES;

/// A level above the finest.
pub trait Coarser {
    /// Adds what a sixteen of finest nodes takes of it.
    fn add<U: Lanes>(&self, unit: U, sixteen: usize, sum: [U::V; 3]) -> [U::V; 3];
}

/// Nodes, from a sixteen on: their own part of P, and that of all coarser levels; gives `r . h`.
pub struct Finest<'a, C> {
    pub coarser: Option<&'a C>,
    pub first: usize,
    pub inverse: &'a [[Sixteen; 6]],
    pub r: &'a [Vectors],
    pub h: &'a mut [Vectors],
}

impl<C: Coarser> Work for Finest<'_, C> {
    type Output = f64;

    #[inline(always)]
    fn on(self, unit: impl Lanes) -> f64 {
        let mut all = unit.load(&[0.0; LANES]);
        for (sixteen, ((h, r), inverse)) in (self.first..).zip(self.h.iter_mut().zip(self.r).zip(self.inverse)) {
            let r = three(unit, r);
            let mut sum = times(unit, inverse, r);
            if let Some(coarser) = self.coarser {
                sum = coarser.add(unit, sixteen, sum);
            }
            for c in 0..3 {
                all = unit.fma(sum[c], r[c], all);
            }
            *h = put(unit, sum);
        }
        unit.store(all).iter().map(|v| f64::from(*v)).sum()
    }
}

/// Blocks, given by six numbers, times vectors.
#[inline(always)]
pub fn times<U: Lanes>(unit: U, m: &[Sixteen; 6], v: [U::V; 3]) -> [U::V; 3] {
    let mut out = v;
    for (out, places) in out.iter_mut().zip([[0, 1, 2], [1, 3, 4], [2, 4, 5]]) {
        *out = unit.mul(unit.load(&m[places[0]]), v[0]);
        *out = unit.fma(unit.load(&m[places[1]]), v[1], *out);
        *out = unit.fma(unit.load(&m[places[2]]), v[2], *out);
    }
    out
}
