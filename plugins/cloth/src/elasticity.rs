//! Plane-stress elasticity of a woven or knitted sheet: orthotropic, with axes along warp and weft.

use crate::vector::Voigt;
use pliant_plugin_api::Fault;
use pliant_plugin_api::lanes::Real;

/// The elasticity tensor C of `stress = C strain`, N/m: its components in Voigt's notation that are not zero by symmetry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ElasticityTensor {
    pub(crate) c11: f64,
    pub(crate) c12: f64,
    pub(crate) c22: f64,
    pub(crate) shear: f64,
}

impl ElasticityTensor {
    /// From components, N/m; refused unless positive definite.
    pub(crate) fn new(c11: f64, c12: f64, c22: f64, shear: f64) -> Result<Self, Fault> {
        let tensor = Self { c11, c12, c22, shear };
        let finite = [c11, c12, c22, shear].iter().all(|c| c.is_finite());
        if finite && c11 > 0.0 && c22 > 0.0 && shear > 0.0 && c12 * c12 < c11 * c22 {
            return Ok(tensor);
        }
        Err(Fault::bad_argument(format!(
            "not positive definite: C11 {c11}, C12 {c12}, C22 {c22}, shear {shear} N/m; allowed is above zero, and C12^2 < C11 C22"
        )))
    }

    /// From engineering constants: Young's moduli along warp and weft, N/m, Poisson's ratio nu12 (contraction of the weft under
    /// stretch of the warp), and shear modulus, N/m; refused unless positive definite.
    pub(crate) fn from_moduli(warp: f64, weft: f64, poisson: f64, shear: f64) -> Result<Self, Fault> {
        let share = 1.0 - poisson * poisson * weft / warp;
        if !(warp > 0.0 && weft > 0.0 && share > 0.0) {
            return Err(Fault::bad_argument(format!(
                "not positive definite: warp {warp}, weft {weft} N/m, Poisson's ratio {poisson}; allowed is nu^2 < warp / weft"
            )));
        }
        Self::new(warp / share, poisson * weft / share, weft / share, shear)
    }

    /// `factor` times as stiff.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        let Self { c11, c12, c22, shear } = self;
        Self { c11: factor * c11, c12: factor * c12, c22: factor * c22, shear: factor * shear }
    }

    /// Stress of a strain, N/m.
    #[inline(always)]
    pub(crate) fn stress<T: Real>(&self, e: Voigt<T>) -> Voigt<T> {
        [e[0] * self.c11 + e[1] * self.c12, e[0] * self.c12 + e[1] * self.c22, e[2] * self.shear]
    }

    /// `m : C^-1 : n` of two stresses in N/m, N/m.
    #[inline(always)]
    pub(crate) fn compliance_product<T: Real>(&self, m: Voigt<T>, n: Voigt<T>) -> T {
        let det = self.c11 * self.c22 - self.c12 * self.c12;
        let normal = m[0] * self.c22 * n[0] - (m[0] * n[1] + m[1] * n[0]) * self.c12 + m[1] * self.c11 * n[1];
        normal * (1.0 / det) + m[2] * n[2] * (1.0 / self.shear)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::contract;

    #[test]
    fn moduli_give_the_components_of_the_patch_test() {
        let c = ElasticityTensor::from_moduli(1000.0, 500.0, 0.3, 50.0).unwrap();
        for (found, expected) in [(c.c11, 1047.1204188), (c.c12, 157.0680628), (c.c22, 523.5602094), (c.shear, 50.0)] {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        let strain = [0.01, -0.003, 0.02];
        let s = c.stress(strain);
        assert!((s[0] - 10.0).abs() < 1e-12 && s[1].abs() < 1e-12 && (s[2] - 1.0).abs() < 1e-12, "{s:?}");
        assert!((c.compliance_product(s, s) - contract(strain, s)).abs() < 1e-12);
    }

    #[test]
    fn a_tensor_that_is_not_positive_definite_is_refused_with_its_numbers() {
        let fault = ElasticityTensor::from_moduli(100.0, 500.0, 0.5, 10.0).unwrap_err();
        assert!(["100", "500", "0.5"].iter().all(|number| fault.reason.contains(number)), "{fault}");
        let fault = ElasticityTensor::new(25.0, -39.8, 6.54, 17.6).unwrap_err();
        assert!(fault.reason.contains("-39.8"), "{fault}");
        assert!(ElasticityTensor::new(1.0, 0.0, 1.0, 0.0).is_err());
        assert!(ElasticityTensor::new(f64::NAN, 0.0, 1.0, 1.0).is_err());
    }
}
