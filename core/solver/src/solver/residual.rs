//! Residuals in double precision, and their conversion to single precision in groups of sixteen nodes.

use crate::algebra::Vec3;
use crate::lanes::interleaved::{Flat, apart};
use crate::lanes::{LANES, Lanes, Vectors, Work, flush_denormals, put};
use bytemuck::{cast_slice, cast_slice_mut};

/// Number of independent partial sums, which hide the latency of additions.
const SUMS: usize = 24;

/// Computes `r = b - product`, or `r = b - r` without a product; all n x 3.
pub struct Residual<'a> {
    pub b: &'a [Vec3],
    pub product: Option<&'a [Vec3]>,
    pub r: &'a mut [Vec3],
}

impl pulp::NullaryFnOnce for Residual<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (r, b) = (cast_slice_mut::<Vec3, f64>(self.r), cast_slice::<Vec3, f64>(self.b));
        match self.product {
            Some(product) => {
                r.iter_mut().zip(b).zip(cast_slice::<Vec3, f64>(product)).for_each(|((r, b), product)| *r = b - product)
            }
            None => r.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r),
        }
    }
}

/// Computes `r . r`.
pub struct SquaredNorm<'a>(pub &'a [Vec3]);

impl pulp::NullaryFnOnce for SquaredNorm<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let (rows, rest) = cast_slice::<Vec3, f64>(self.0).as_chunks::<SUMS>();
        let mut sums = [0.0; SUMS];
        for row in rows {
            (0..SUMS).for_each(|k| sums[k] += row[k] * row[k]);
        }
        sums.iter().sum::<f64>() + rest.iter().map(|v| v * v).sum::<f64>()
    }
}

/// Multiplies vectors by `scale`, rounds them to single precision and stores them in groups of sixteen nodes.
pub struct ScaledBySixteen<'a> {
    pub scale: f64,
    pub r: &'a [Vec3],
    pub to: &'a mut [Vectors],
}

impl Work for ScaledBySixteen<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        for (to, r) in self.to.iter_mut().zip(self.r.chunks(LANES)) {
            let mut flat: Flat = [0.0; 3 * LANES];
            for (flat, r) in flat.iter_mut().zip(cast_slice::<Vec3, f64>(r)) {
                *flat = flush_denormals((self.scale * r) as f32);
            }
            *to = put(unit, apart(unit, &flat));
        }
    }
}
