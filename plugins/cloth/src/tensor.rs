//! Plane-stress elasticity of a woven or knitted sheet: orthotropic, in the frame of warp and weft.
//!
//! Strain and stress of the sheet are three numbers, (11, 22, 12): of strain the last is gamma = 2 e12.

use pliant_plugin_api::Fault;
use pliant_plugin_api::lanes::Real;

/// N/m. `sigma = C e`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tensor {
    pub(crate) c11: f64,
    pub(crate) c12: f64,
    pub(crate) c22: f64,
    pub(crate) shear: f64,
}

impl Tensor {
    /// If it is positive definite.
    pub(crate) fn new(c11: f64, c12: f64, c22: f64, shear: f64) -> Result<Self, Fault> {
        let given = Self { c11, c12, c22, shear };
        let finite = [c11, c12, c22, shear].iter().all(|c| c.is_finite());
        if finite && c11 > 0.0 && c22 > 0.0 && shear > 0.0 && c12 * c12 < c11 * c22 {
            return Ok(given);
        }
        Err(Fault::bad_argument(format!(
            "not positive definite: C11 {c11}, C12 {c12}, C22 {c22}, shear {shear} N/m; wanted above zero, and C12^2 < C11 C22"
        )))
    }

    /// From Young's moduli of warp and weft, N/m, Poisson's ratio nu12 (shortening of the weft by stretch of the warp) and
    /// shear, N/m.
    pub(crate) fn from_moduli(warp: f64, weft: f64, poisson: f64, shear: f64) -> Result<Self, Fault> {
        let share = 1.0 - poisson * poisson * weft / warp;
        if !(warp > 0.0 && weft > 0.0 && share > 0.0) {
            return Err(Fault::bad_argument(format!(
                "not positive definite: warp {warp}, weft {weft} N/m, Poisson's ratio {poisson}; wanted nu^2 < warp / weft"
            )));
        }
        Self::new(warp / share, poisson * weft / share, weft / share, shear)
    }

    /// N/m
    #[inline(always)]
    pub(crate) fn stress<T: Real>(&self, e: [T; 3]) -> [T; 3] {
        [e[0] * self.c11 + e[1] * self.c12, e[0] * self.c12 + e[1] * self.c22, e[2] * self.shear]
    }

    /// `m C^-1 n` of two stresses
    #[inline(always)]
    pub(crate) fn compliant<T: Real>(&self, m: [T; 3], n: [T; 3]) -> T {
        let det = self.c11 * self.c22 - self.c12 * self.c12;
        let plane = m[0] * self.c22 * n[0] - (m[0] * n[1] + m[1] * n[0]) * self.c12 + m[1] * self.c11 * n[1];
        plane * (1.0 / det) + m[2] * n[2] * (1.0 / self.shear)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moduli_give_the_coefficients_of_the_patch_test() {
        let c = Tensor::from_moduli(1000.0, 500.0, 0.3, 50.0).unwrap();
        for (got, want) in [(c.c11, 1047.1204188), (c.c12, 157.0680628), (c.c22, 523.5602094), (c.shear, 50.0)] {
            assert!((got - want).abs() < 1e-6, "{got} {want}");
        }
        let (e, s) = ([0.01, -0.003, 0.02], c.stress([0.01, -0.003, 0.02]));
        assert!((s[0] - 10.0).abs() < 1e-12 && s[1].abs() < 1e-12 && (s[2] - 1.0).abs() < 1e-12, "{s:?}");
        let twice = e[0] * s[0] + e[1] * s[1] + e[2] * s[2];
        assert!((c.compliant(s, s) - twice).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_definite_is_refused_with_its_numbers() {
        let fault = Tensor::from_moduli(100.0, 500.0, 0.5, 10.0).unwrap_err();
        assert!(
            fault.reason.contains("100") && fault.reason.contains("500") && fault.reason.contains("0.5"),
            "{fault}"
        );
        let fault = Tensor::new(25.0, -39.8, 6.54, 17.6).unwrap_err();
        assert!(fault.reason.contains("-39.8"), "{fault}");
        assert!(Tensor::new(1.0, 0.0, 1.0, 0.0).is_err() && Tensor::new(f64::NAN, 0.0, 1.0, 1.0).is_err());
    }
}
