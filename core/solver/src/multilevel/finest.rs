//! The finest level of P: block Jacobi's share, and what comes from the coarser ones.

use crate::lanes::symmetric::times;
use crate::lanes::{LANES, Lanes, Sixteen, Vectors, Work, put, three};

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
