//! The stable Neo-Hookean energy density of Smith, de Goes and Kim (2018), "Stable Neo-Hookean Flesh Simulation":
//!
//! `psi(F) = mu/2 (I_C - 3) + lambda/2 (J - alpha)^2 - mu/2 ln(I_C + 1)`, `alpha = 1 + 3 mu / (4 lambda)`
//!
//! It is finite for every F, and its force restores an inverted element. The constants are those of their section 3.4, chosen so that
//! small strains follow Hooke's law with the Lame constants of Young's modulus and Poisson's ratio.

use crate::matrix::{Mat3, Vec3, cofactors, determinant, norm_squared};
use crate::svd::{Eigen, Svd, svd, symmetric_eigen};
use pliant_plugin_api::lanes::Real;

/// Constants of the model.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moduli {
    /// Coefficient mu, Pa.
    mu: f64,
    /// Coefficient lambda, Pa.
    lambda: f64,
    /// J at which the volume term is zero.
    alpha: f64,
}

/// The second derivative of the energy density by F, in the frames of the principal stretches: `F = U diag(s) V^T`.
///
/// For entries of `U^T dF V`, it couples the diagonal ones to each other, and each off-diagonal one to itself and its mirror image.
pub(crate) struct EnergyHessian<T> {
    pub(crate) u: Mat3<T>,
    pub(crate) v: Mat3<T>,
    /// Between diagonal entries, Pa.
    pub(crate) stretch: Mat3<T>,
    /// Of the entry (i, j), i not j, with itself, Pa.
    pub(crate) shear_own: Mat3<T>,
    /// Of the entry (i, j), i not j, with (j, i), Pa.
    pub(crate) shear_cross: Mat3<T>,
}

impl Moduli {
    /// From the Lame constants of small strains: shear modulus and first Lame constant, Pa.
    pub(crate) fn new(shear: f64, first_lame: f64) -> Self {
        let (mu, lambda) = (4.0 / 3.0 * shear, first_lame + 5.0 / 6.0 * shear);
        Self { mu, lambda, alpha: 1.0 + 0.75 * mu / lambda }
    }

    /// Energy density, zero at rest, J/m^3.
    pub(crate) fn energy(&self, f: &Mat3) -> f64 {
        let (ic, j) = (norm_squared(f), determinant(f));
        let one_minus_alpha = 1.0 - self.alpha;
        // ln(ic + 1) - ln(4) without cancellation near rest.
        let log = libm::log1p((ic - 3.0) / 4.0);
        0.5 * self.mu * (ic - 3.0 - log) + 0.5 * self.lambda * (j - 1.0) * (j - 1.0 + 2.0 * one_minus_alpha)
    }

    /// First Piola-Kirchhoff stress dpsi/dF, Pa.
    #[inline(always)]
    pub(crate) fn stress<T: Real>(&self, f: &Mat3<T>) -> Mat3<T> {
        let shear = self.shear(norm_squared(f));
        let pressure = self.pressure(determinant(f));
        let cofactors = cofactors(f);
        let mut stress = *f;
        for i in 0..3 {
            stress[i] = f[i] * shear + cofactors[i] * pressure;
        }
        stress
    }

    /// Coefficient of F in the stress, Pa.
    #[inline(always)]
    fn shear<T: Real>(&self, ic: T) -> T {
        let one = ic.splat(1.0);
        (one - one / (ic + one)) * self.mu
    }

    /// Coefficient of dJ/dF in the stress, Pa.
    #[inline(always)]
    fn pressure<T: Real>(&self, j: T) -> T {
        (j - j.splat(self.alpha)) * self.lambda
    }

    /// d2psi/dF2 in closed form (their section 4; Smith, de Goes and Kim 2019), made positive semi-definite if `project`.
    #[inline(always)]
    pub(crate) fn hessian<T: Real>(&self, f: &Mat3<T>, project: bool) -> EnergyHessian<T> {
        let Svd { u, s, v } = svd(f);
        let ic = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
        let (zero, one) = (ic.splat(0.0), ic.splat(1.0));
        let shear = self.shear(ic);
        let pressure = self.pressure(s[0] * s[1] * s[2]);
        let shear_slope = ic.splat(2.0 * self.mu) / ((ic + one) * (ic + one));
        let dj_ds = [s[1] * s[2], s[2] * s[0], s[0] * s[1]];
        let zeros = [Vec3([zero; 3]); 3];
        let (mut stretch, mut shear_own, mut shear_cross) = (zeros, zeros, zeros);
        for i in 0..3 {
            for j in 0..3 {
                stretch[i][j] = shear_slope * s[i] * s[j] + dj_ds[i] * dj_ds[j] * self.lambda;
                if i == j {
                    stretch[i][j] = stretch[i][j] + shear;
                    continue;
                }
                let coupling = pressure * s[3 - i - j];
                stretch[i][j] = stretch[i][j] + coupling;
                // Eigenvalues for the symmetric and the antisymmetric combination of (i, j) and (j, i).
                let (mut symmetric, mut antisymmetric) = (shear - coupling, shear + coupling);
                if project {
                    (symmetric, antisymmetric) = (zero.max(symmetric), zero.max(antisymmetric));
                }
                shear_own[i][j] = (symmetric + antisymmetric) * 0.5;
                shear_cross[i][j] = (symmetric - antisymmetric) * 0.5;
            }
        }
        if project {
            stretch = positive_part(stretch);
        }
        EnergyHessian { u, v, stretch, shear_own, shear_cross }
    }
}

/// The nearest positive semi-definite matrix to a symmetric one: negative eigenvalues become zero.
#[inline(always)]
fn positive_part<T: Real>(a: Mat3<T>) -> Mat3<T> {
    let (zero, least) = (a[0][0].splat(0.0), a[0][0].min_positive());
    // Sylvester's criterion: the matrix is positive definite if its leading minors are positive. NaN counts as positive here, so that it
    // stays.
    let (first, second, third) = (a[0][0], a[0][0] * a[1][1] - a[0][1] * a[0][1], determinant(&a));
    let is_definite = first.if_less(least, zero, second.if_less(least, zero, third));
    if !is_definite.any_below(f64::MIN_POSITIVE) {
        return a;
    }
    let Eigen { values, vectors: v } = symmetric_eigen(a);
    let w = [values[0].max(zero), values[1].max(zero), values[2].max(zero)];
    let mut out = a;
    for i in 0..3 {
        for j in 0..3 {
            let (p, q) = (v[i], v[j]);
            let projected = w[0] * p[0] * q[0] + w[1] * p[1] * q[1] + w[2] * p[2] * q[2];
            // Definite lanes keep their matrix, so that they do not depend on their neighbours.
            out[i][j] = is_definite.if_less(least, projected, a[i][j]);
        }
    }
    out
}
