//! The angle of a point, from sums, products and quotients alone: the system's own has other last digits on other processors.

use pliant_plugin_api::lanes::Real;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// rad, in [-pi, pi], of (`x`, `y`); 0 at the origin. Rational approximation of Moshier (1989), within 1e-15 of the angle.
#[inline(always)]
pub(crate) fn angle_of<T: Real>(y: T, x: T) -> T {
    let (up, right, zero) = (y.abs(), x.abs(), x.splat(0.0));
    let (most, least) = (right.if_less(up, up, right), right.if_less(up, right, up));
    // Their quotient is in [0, 1]; beyond 0.66 it is taken as 45 degrees and a rest. What is not finite stays so: comparing alone
    // would lose it.
    let (one, steep) = (x.splat(1.0), most * 0.66);
    let base = steep.if_less(least, x.splat(FRAC_PI_4), zero);
    let (above, below) = (steep.if_less(least, least - most, least), steep.if_less(least, least + most, most));
    let rest = zero.if_less(most, above / below, zero) + zero * x + zero * y;
    let z = rest * rest;
    let (mut top, mut bottom) = (zero, one);
    for i in 0..P.len() {
        top = top * z + x.splat(P[i]);
        bottom = bottom * z + x.splat(Q[i]);
    }
    let small = base + (rest * (z * top / bottom) + rest);
    let quarter = right.if_less(up, x.splat(FRAC_PI_2) - small, small);
    let half = x.if_less(zero, x.splat(PI) - quarter, quarter);
    y.if_less(zero, -half, half)
}

const P: [f64; 5] =
    [-8.750608600031904e-1, -1.615753718733365e1, -7.500855792314705e1, -1.2288666844901361e2, -6.485021904942025e1];
const Q: [f64; 5] =
    [2.485846490142306e1, 1.650270098316988e2, 4.328810604912903e2, 4.853903996359137e2, 1.945506571482614e2];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_round() {
        for i in -3600..=3600 {
            let angle = f64::from(i) / 3600.0 * std::f64::consts::PI;
            for size in [1e-200, 1e-3, 1.0, 1e200] {
                let (s, c) = angle.sin_cos();
                let (got, want) = (angle_of(size * s, size * c), (size * s).atan2(size * c));
                assert!((got - want).abs() <= 2e-15 * want.abs(), "{angle}: {got} {want}");
            }
        }
    }

    #[test]
    fn axes_and_nothing() {
        for (y, x, want) in
            [(0.0, 0.0, 0.0), (0.0, 2.0, 0.0), (3.0, 0.0, FRAC_PI_2), (-3.0, 0.0, -FRAC_PI_2), (0.0, -1.0, PI)]
        {
            assert_eq!(angle_of(y, x), want);
        }
        assert!(
            angle_of(f64::NAN, 1.0).is_nan() && angle_of(1.0, f64::NAN).is_nan() && angle_of(f64::NAN, 0.0).is_nan()
        );
    }
}
