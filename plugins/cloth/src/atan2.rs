//! `atan2` from sums, products and quotients alone, so that its results are bitwise the same on every system.

use pliant_plugin_api::lanes::Real;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Angle of the point (`x`, `y`) against the x axis, rad, in [-pi, pi]; 0 at the origin. The sign of a zero is ignored. Relative error below 2e-15 for
/// finite coordinates whose sum does not overflow, by the rational approximation of Cephes (Moshier 1989); NaN if a coordinate is NaN or infinite.
#[inline(always)]
pub(crate) fn atan2<T: Real>(y: T, x: T) -> T {
    let (abs_y, abs_x, zero) = (y.abs(), x.abs(), x.splat(0.0));
    let larger = abs_x.if_less(abs_y, abs_y, abs_x);
    let smaller = abs_x.if_less(abs_y, abs_x, abs_y);
    // The quotient is in [0, 1]. Above 0.66 its angle is 45 degrees and the angle of (smaller - larger) / (smaller + larger).
    let (one, steep) = (x.splat(1.0), larger * 0.66);
    let base = steep.if_less(smaller, x.splat(FRAC_PI_4), zero);
    let numerator = steep.if_less(smaller, smaller - larger, smaller);
    let denominator = steep.if_less(smaller, smaller + larger, larger);
    // A comparison with NaN is false, so the last two terms are there to pass NaN on.
    let tangent = zero.if_less(larger, numerator / denominator, zero) + zero * x + zero * y;
    let z = tangent * tangent;
    let (mut p, mut q) = (zero, one);
    for i in 0..P.len() {
        p = p * z + x.splat(P[i]);
        q = q * z + x.splat(Q[i]);
    }
    let octant = base + (tangent * (z * p / q) + tangent);
    let quadrant = abs_x.if_less(abs_y, x.splat(FRAC_PI_2) - octant, octant);
    let half_plane = x.if_less(zero, x.splat(PI) - quadrant, quadrant);
    y.if_less(zero, -half_plane, half_plane)
}

/// Coefficients of the numerator, highest power first.
const P: [f64; 5] =
    [-8.750608600031904e-1, -1.615753718733365e1, -7.500855792314705e1, -1.2288666844901361e2, -6.485021904942025e1];
/// Coefficients of the denominator below its leading 1, highest power first.
const Q: [f64; 5] =
    [2.485846490142306e1, 1.650270098316988e2, 4.328810604912903e2, 4.853903996359137e2, 1.945506571482614e2];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_standard_library_at_every_angle_and_radius() {
        for i in -3600..=3600 {
            let angle = f64::from(i) / 3600.0 * std::f64::consts::PI;
            for radius in [1e-200, 1e-3, 1.0, 1e200] {
                let (s, c) = angle.sin_cos();
                let (found, expected) = (atan2(radius * s, radius * c), (radius * s).atan2(radius * c));
                assert!((found - expected).abs() <= 2e-15 * expected.abs(), "{angle}: {found} {expected}");
            }
        }
    }

    #[test]
    fn axes_origin_and_nan() {
        for (y, x, expected) in
            [(0.0, 0.0, 0.0), (0.0, 2.0, 0.0), (3.0, 0.0, FRAC_PI_2), (-3.0, 0.0, -FRAC_PI_2), (0.0, -1.0, PI)]
        {
            assert_eq!(atan2(y, x), expected);
        }
        assert!(atan2(f64::NAN, 1.0).is_nan() && atan2(1.0, f64::NAN).is_nan() && atan2(f64::NAN, 0.0).is_nan());
    }
}
