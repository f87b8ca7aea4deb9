//! The finest level of the preconditioner P: its weighted block Jacobi term plus the prolongation of the coarse levels.

use crate::lanes::symmetric::times;
use crate::lanes::{LANES, Lanes, Sixteen, Vectors, Work, put, three};

/// The first coarse level.
pub trait Coarser {
    /// Adds its prolongation to a group of sixteen finest nodes.
    fn add<U: Lanes>(&self, unit: U, sixteen: usize, sum: [U::V; 3]) -> [U::V; 3];
}

/// Computes `h = P r` for the nodes from a group of sixteen on. Returns their `r . h`.
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
