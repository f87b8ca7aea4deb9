//! The stable Neo-Hookean energy density of Smith, de Goes and Kim (2018), "Stable Neo-Hookean Flesh Simulation":
//!
//! `psi(F) = mu/2 (I_C - 3) + lambda/2 (J - alpha)^2 - mu/2 ln(I_C + 1)`, `alpha = 1 + 3 mu / (4 lambda)`
//!
//! It is finite for every F, and its force restores an inverted element. The constants are those of their section 3.4, chosen so that
//! small strains follow Hooke's law with the Lame constants of Young's modulus and Poisson's ratio.

use super::hessian::{EnergyHessian, PrincipalModes};
use super::matrix::{Mat3, cofactors, determinant, norm_squared};
use super::svd::svd;
use crate::lanes::{Real, Vec3};

/// The Lame constants of small strains, shear modulus and first constant, Pa, from Young's modulus (Pa) and Poisson's ratio (1, below 0.5).
pub fn lame_constants(young: f64, poisson: f64) -> [f64; 2] {
    [young / (2.0 * (1.0 + poisson)), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))]
}

/// The energy of a material with these constants.
#[derive(Clone, Copy, Debug)]
pub struct StableNeoHookean {
    /// Coefficient mu, Pa.
    mu: f64,
    /// Coefficient lambda, Pa.
    lambda: f64,
    /// J at which the volume term is zero.
    alpha: f64,
}

impl StableNeoHookean {
    /// From the Lame constants of small strains: shear modulus and first Lame constant, Pa.
    pub fn new(shear: f64, first_lame: f64) -> Self {
        let (mu, lambda) = (4.0 / 3.0 * shear, first_lame + 5.0 / 6.0 * shear);
        Self { mu, lambda, alpha: 1.0 + 0.75 * mu / lambda }
    }

    /// Energy density, zero at rest, J/m^3.
    pub fn energy(&self, f: &Mat3) -> f64 {
        let (ic, j) = (norm_squared(f), determinant(f));
        let one_minus_alpha = 1.0 - self.alpha;
        // ln(ic + 1) - ln(4) without cancellation near rest.
        let log = libm::log1p((ic - 3.0) / 4.0);
        0.5 * self.mu * (ic - 3.0 - log) + 0.5 * self.lambda * (j - 1.0) * (j - 1.0 + 2.0 * one_minus_alpha)
    }

    /// The stretch across a bar that is stretched by `stretch` along its axis, above 0, with nothing that holds its sides: where the stress across it is zero.
    pub fn lateral_stretch(&self, stretch: f64) -> f64 {
        // Zero stress across, `mu (1 - 1/(I_C + 1)) + lambda l (l s - alpha) = 0`, is a quadratic equation in the square s of the lateral stretch with one
        // positive root.
        let (square, stiffness) = (stretch * stretch, self.lambda * stretch);
        let rest = square + 1.0;
        let a = 2.0 * self.lambda * square;
        let b = 2.0 * self.mu + stiffness * (stretch * rest - 2.0 * self.alpha);
        let c = self.mu * square - stiffness * self.alpha * rest;
        let root = (b * b - 4.0 * a * c).sqrt();
        // The form of the root that does not cancel.
        if b > 0.0 { (-2.0 * c / (b + root)).sqrt() } else { ((root - b) / (2.0 * a)).sqrt() }
    }

    /// Nominal stress of that bar, Pa.
    pub fn bar_stress(&self, stretch: f64) -> f64 {
        let across = self.lateral_stretch(stretch).powi(2);
        let ic = stretch * stretch + 2.0 * across;
        self.shear(ic) * stretch + self.pressure(stretch * across) * across
    }

    /// First Piola-Kirchhoff stress dpsi/dF, Pa.
    #[inline(always)]
    pub fn stress<T: Real>(&self, f: &Mat3<T>) -> Mat3<T> {
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
    pub fn hessian<T: Real>(&self, f: &Mat3<T>, project: bool) -> EnergyHessian<T> {
        let svd = svd(f);
        let s = svd.s;
        let ic = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
        let (zero, one) = (ic.splat(0.0), ic.splat(1.0));
        let shear = self.shear(ic);
        let pressure = self.pressure(s[0] * s[1] * s[2]);
        let shear_slope = ic.splat(2.0 * self.mu) / ((ic + one) * (ic + one));
        let dj_ds = [s[1] * s[2], s[2] * s[0], s[0] * s[1]];
        let mut modes = PrincipalModes {
            stretch: [Vec3([zero; 3]); 3],
            symmetric: Vec3([zero; 3]),
            antisymmetric: Vec3([zero; 3]),
        };
        for i in 0..3 {
            for j in 0..3 {
                let own = shear_slope * s[i] * s[j] + dj_ds[i] * dj_ds[j] * self.lambda;
                modes.stretch[i][j] = if i == j { own + shear } else { own + pressure * s[3 - i - j] };
            }
            let coupling = pressure * s[i];
            (modes.symmetric[i], modes.antisymmetric[i]) = (shear - coupling, shear + coupling);
        }
        EnergyHessian::new(&svd, modes, project)
    }
}
