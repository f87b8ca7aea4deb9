//! Conversion of Kawabata evaluation system (KES-FB) results to SI units.

/// One gram-force, N.
const GRAM_FORCE: f64 = 9.80665e-3;

/// Bending rigidity in N m from B in gf cm^2/cm.
pub fn bending_rigidity(b: f64) -> f64 {
    b * GRAM_FORCE * 1e-2
}

/// Shear stiffness in N/m from G in gf/(cm deg).
pub fn shear_stiffness(g: f64) -> f64 {
    g * GRAM_FORCE * 1e2 * 180.0 / std::f64::consts::PI
}

/// Secant Young's modulus of the sheet at `strain`, in N/m, from EMT (the strain at 500 gf/cm, in %) and the linearity LT. The
/// load curve is taken as `F = Fm (e / em)^p` with `LT = 2 / (p + 1)`.
#[allow(clippy::disallowed_methods, reason = "checks the moduli in the table of fabrics; no run calls it")]
pub fn secant_modulus(emt: f64, lt: f64, strain: f64) -> f64 {
    let (max_load, max_strain) = (500.0 * GRAM_FORCE * 1e2, emt / 100.0);
    max_load / max_strain * (strain / max_strain).powf(2.0 / lt - 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversions() {
        assert!((bending_rigidity(1.0) - 98.0665e-6).abs() < 1e-12);
        assert!((bending_rigidity(0.172) - 16.87e-6).abs() < 1e-8);
        assert!((shear_stiffness(1.0) - 56.188).abs() < 1e-3 && (shear_stiffness(2.18) - 122.5).abs() < 0.05);
        // At EMT the secant is 500 gf/cm over the strain, whatever the linearity.
        let at_emt = secant_modulus(5.515, 0.712, 0.05515);
        assert!((at_emt - 8891.0).abs() < 1.0, "{at_emt}");
        let at_one_percent = secant_modulus(5.515, 0.712, 0.01);
        assert!((at_one_percent - 2234.0).abs() < 3.0, "{at_one_percent}");
        assert!((secant_modulus(5.0, 1.0, 0.01) - 9806.65).abs() < 1e-6, "a straight load curve");
    }
}
