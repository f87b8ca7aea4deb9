//! The energy of Smith, de Goes and Kim (2018), "Stable Neo-Hookean Flesh Simulation", per unit of rest volume:
//!
//! `psi(F) = mu/2 (I_C - 3) + lambda/2 (J - alpha)^2 - mu/2 ln(I_C + 1)`, `alpha = 1 + 3 mu / (4 lambda)`
//!
//! It has no pole: every F has a finite energy, and one turned inside out is pushed back. The constants are theirs of
//! section 3.4, chosen so that small strains follow Hooke's law with the Lame constants of Young's modulus and Poisson's
//! ratio.

use crate::matrix::{M3, cofactors, determinant, eigen, singular, squared};

/// Constants of the model, Pa.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moduli {
    mu: f64,
    lambda: f64,
    alpha: f64,
}

/// How the energy bends around a state, in the frames of its principal stretches.
pub(crate) struct Curvature {
    /// `F = U diag(s) V^T`
    pub(crate) u: M3,
    pub(crate) v: M3,
    /// Between stretches, Pa.
    pub(crate) scaling: M3,
    /// Of the entries (i, j) and (j, i), i not j: with itself, and with the other; Pa.
    pub(crate) own: M3,
    pub(crate) other: M3,
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
    pub(crate) fn stress(&self, f: &M3) -> M3 {
        let shear = self.shear(squared(f));
        let pressure = self.pressure(determinant(f));
        let cofactors = cofactors(f);
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| shear * f[i][j] + pressure * cofactors[i][j]))
    }

    fn shear(&self, ic: f64) -> f64 {
        self.mu * (1.0 - 1.0 / (ic + 1.0))
    }

    fn pressure(&self, j: f64) -> f64 {
        self.lambda * (j - self.alpha)
    }

    /// d2psi/dF2 in closed form (their section 4; Smith, de Goes and Kim 2019); with `project`, without its negative part.
    pub(crate) fn curvature(&self, f: &M3, project: bool) -> Curvature {
        let (u, s, v) = singular(f);
        let ic = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
        let shear = self.shear(ic);
        let pressure = self.pressure(s[0] * s[1] * s[2]);
        let growth = 2.0 * self.mu / ((ic + 1.0) * (ic + 1.0));
        let slope = [s[1] * s[2], s[2] * s[0], s[0] * s[1]]; // dJ/ds
        let (mut scaling, mut own, mut other) = ([[0.0; 3]; 3], [[0.0; 3]; 3], [[0.0; 3]; 3]);
        for i in 0..3 {
            for j in 0..3 {
                scaling[i][j] = growth * s[i] * s[j] + self.lambda * slope[i] * slope[j];
                if i == j {
                    scaling[i][j] += shear;
                    continue;
                }
                let third = 3 - i - j;
                scaling[i][j] += pressure * s[third];
                let (flip, twist) = (shear - pressure * s[third], shear + pressure * s[third]);
                let (flip, twist) = if project { (flip.max(0.0), twist.max(0.0)) } else { (flip, twist) };
                (own[i][j], other[i][j]) = (0.5 * (flip + twist), 0.5 * (flip - twist));
            }
        }
        if project {
            scaling = without_negative(scaling);
        }
        Curvature { u, v, scaling, own, other }
    }
}

/// The nearest positive semi-definite matrix to a symmetric one.
fn without_negative(a: M3) -> M3 {
    // Sylvester's criterion first: most states need no eigenvalues.
    if a[0][0] > 0.0 && a[0][0] * a[1][1] > a[0][1] * a[0][1] && determinant(&a) > 0.0 {
        return a;
    }
    let (values, v) = eigen(a);
    if values.iter().all(|w| *w >= 0.0) {
        return a;
    }
    let w = values.map(|w| w.max(0.0));
    v.map(|p| v.map(|q| w[0] * p[0] * q[0] + w[1] * p[1] * q[1] + w[2] * p[2] * q[2]))
}
