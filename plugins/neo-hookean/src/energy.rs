//! The energy of Smith, de Goes and Kim (2018), "Stable Neo-Hookean Flesh Simulation", per unit of rest volume:
//!
//! `psi(F) = mu/2 (I_C - 3) + lambda/2 (J - alpha)^2 - mu/2 ln(I_C + 1)`, `alpha = 1 + 3 mu / (4 lambda)`
//!
//! It has no pole: every F has a finite energy, and one turned inside out is pushed back. The constants are theirs of
//! section 3.4, chosen so that small strains follow Hooke's law with the Lame constants of Young's modulus and Poisson's
//! ratio.

use crate::matrix::{M3, cofactors, determinant, eigen, singular, squared};
use pliant_plugin_api::lanes::Real;

/// Constants of the model, Pa.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moduli {
    mu: f64,
    lambda: f64,
    alpha: f64,
}

/// How the energy bends around a state, in the frames of its principal stretches.
pub(crate) struct Curvature<T> {
    /// `F = U diag(s) V^T`
    pub(crate) u: M3<T>,
    pub(crate) v: M3<T>,
    /// Between stretches, Pa.
    pub(crate) scaling: M3<T>,
    /// Of the entries (i, j) and (j, i), i not j: with itself, and with the other; Pa.
    pub(crate) own: M3<T>,
    pub(crate) other: M3<T>,
}

impl Moduli {
    /// From the Lame constants of small strains, Pa.
    pub(crate) fn new(shear: f64, dilation: f64) -> Self {
        let (mu, lambda) = (4.0 / 3.0 * shear, dilation + 5.0 / 6.0 * shear);
        Self { mu, lambda, alpha: 1.0 + 0.75 * mu / lambda }
    }

    /// J/m^3, zero at rest
    pub(crate) fn energy(&self, f: &M3) -> f64 {
        let (ic, j) = (squared(f), determinant(f));
        let rest = 1.0 - self.alpha;
        // ln(ic + 1) - ln(4), without the loss of digits near rest.
        let growth = ((ic - 3.0) / 4.0).ln_1p();
        0.5 * self.mu * (ic - 3.0 - growth) + 0.5 * self.lambda * (j - 1.0) * (j - 1.0 + 2.0 * rest)
    }

    /// First Piola-Kirchhoff stress dpsi/dF, Pa.
    #[inline(always)]
    pub(crate) fn stress<T: Real>(&self, f: &M3<T>) -> M3<T> {
        let shear = self.shear(squared(f));
        let pressure = self.pressure(determinant(f));
        let cofactors = cofactors(f);
        let mut stress = *f;
        for i in 0..3 {
            for j in 0..3 {
                stress[i][j] = shear * f[i][j] + pressure * cofactors[i][j];
            }
        }
        stress
    }

    #[inline(always)]
    fn shear<T: Real>(&self, ic: T) -> T {
        let one = ic.splat(1.0);
        (one - one / (ic + one)) * self.mu
    }

    #[inline(always)]
    fn pressure<T: Real>(&self, j: T) -> T {
        (j - j.splat(self.alpha)) * self.lambda
    }

    /// d2psi/dF2 in closed form (their section 4; Smith, de Goes and Kim 2019); with `project`, without its negative part.
    #[inline(always)]
    pub(crate) fn curvature<T: Real>(&self, f: &M3<T>, project: bool) -> Curvature<T> {
        let (u, s, v) = singular(f);
        let ic = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
        let (zero, one) = (ic.splat(0.0), ic.splat(1.0));
        let shear = self.shear(ic);
        let pressure = self.pressure(s[0] * s[1] * s[2]);
        let growth = ic.splat(2.0 * self.mu) / ((ic + one) * (ic + one));
        let slope = [s[1] * s[2], s[2] * s[0], s[0] * s[1]]; // dJ/ds
        let (mut scaling, mut own, mut other) = ([[zero; 3]; 3], [[zero; 3]; 3], [[zero; 3]; 3]);
        for i in 0..3 {
            for j in 0..3 {
                scaling[i][j] = growth * s[i] * s[j] + slope[i] * slope[j] * self.lambda;
                if i == j {
                    scaling[i][j] = scaling[i][j] + shear;
                    continue;
                }
                let third = pressure * s[3 - i - j];
                scaling[i][j] = scaling[i][j] + third;
                let (mut flip, mut twist) = (shear - third, shear + third);
                if project {
                    (flip, twist) = (zero.max(flip), zero.max(twist));
                }
                (own[i][j], other[i][j]) = ((flip + twist) * 0.5, (flip - twist) * 0.5);
            }
        }
        if project {
            scaling = without_negative(scaling);
        }
        Curvature { u, v, scaling, own, other }
    }
}

/// The nearest positive semi-definite matrix to a symmetric one.
#[inline(always)]
fn without_negative<T: Real>(a: M3<T>) -> M3<T> {
    let (zero, least) = (a[0][0].splat(0.0), a[0][0].min_positive());
    let (first, second, third) = (a[0][0], a[0][0] * a[1][1] - a[0][1] * a[0][1], determinant(&a));
    // What is no number stays as it is.
    let surely = first.if_less(least, zero, second.if_less(least, zero, third));
    if !surely.any_below(f64::MIN_POSITIVE) {
        return a;
    }
    let (values, v) = eigen(a);
    let w = [values[0].max(zero), values[1].max(zero), values[2].max(zero)];
    let mut out = a;
    for i in 0..3 {
        for j in 0..3 {
            let (p, q) = (v[i], v[j]);
            let near = w[0] * p[0] * q[0] + w[1] * p[1] * q[1] + w[2] * p[2] * q[2];
            // One that is positive must not depend on others that are not.
            out[i][j] = surely.if_less(least, near, a[i][j]);
        }
    }
    out
}
