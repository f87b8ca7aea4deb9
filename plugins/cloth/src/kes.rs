//! Numbers of the Kawabata evaluation system (KES-FB) in SI units.

/// N, of 1 gf.
const GRAM_FORCE: f64 = 9.80665e-3;

/// N m, bending rigidity from B, gf cm^2/cm.
pub fn bending(b: f64) -> f64 {
    b * GRAM_FORCE * 1e-2
}

/// N/m, shear stiffness from G, gf/(cm deg).
pub fn shear(g: f64) -> f64 {
    g * GRAM_FORCE * 1e2 * 180.0 / std::f64::consts::PI
}

/// N/m, Young's modulus of the sheet as the secant at a working `strain`, from EMT (%, the strain at 500 gf/cm) and linearity
/// LT: the curve is taken as `F = Fm (e / em)^p` with `LT = 2 / (p + 1)`.
pub fn secant(emt: f64, lt: f64, strain: f64) -> f64 {
    let (most, at) = (500.0 * GRAM_FORCE * 1e2, emt / 100.0);
    most / at * (strain / at).powf(2.0 / lt - 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units() {
        assert!((bending(1.0) - 98.0665e-6).abs() < 1e-12 && (bending(0.172) - 16.87e-6).abs() < 1e-8);
        assert!((shear(1.0) - 56.188).abs() < 1e-3 && (shear(2.18) - 122.5).abs() < 0.05);
        // At EMT itself the secant is 500 gf/cm over the strain, whatever the linearity.
        assert!((secant(5.515, 0.712, 0.05515) - 8891.0).abs() < 1.0, "{}", secant(5.515, 0.712, 0.05515));
        assert!((secant(5.515, 0.712, 0.01) - 2234.0).abs() < 3.0, "{}", secant(5.515, 0.712, 0.01));
        assert!((secant(5.0, 1.0, 0.01) - 9806.65).abs() < 1e-6, "a straight line");
    }
}
