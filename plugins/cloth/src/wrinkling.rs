//! Wrinkling at a scale below the mesh: compression gives way, tension stays (tension field: Reissner 1938).
//!
//! The relaxed energy is the least over all shortenings by wrinkles, `min C : (e + z)^2 / 2` over positive semi-definite z (Pipkin
//! 1986). The stress is C : e where that is positive semi-definite, zero where the strain is negative semi-definite, and uniaxial
//! tension along the direction t of `max E(t) e(t)^2 / 2` otherwise.

use crate::elasticity::ElasticityTensor;
use crate::vector::{Vec2, Voigt, contract};

/// Directions evaluated before the best is refined.
const DIRECTIONS: usize = 24;
/// Cosine and sine of the angle between two directions, pi / 24.
const STEP: Vec2 = [0.9914448613738104, 0.13052619222005157];
/// Bisections of an interval of twice that angle, to the last digit of an f64.
const BISECTIONS: usize = 55;

/// Stress and energy of a sheet that wrinkles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Relaxed {
    /// Membrane stress, N/m.
    pub(crate) stress: Voigt,
    /// Energy per area at rest, J/m^2.
    pub(crate) energy: f64,
}

/// Relaxed stress and energy at a strain `e`.
pub(crate) fn relax(c: &ElasticityTensor, e: Voigt) -> Relaxed {
    let q = c.stress(e);
    if q[0] + q[1] >= 0.0 && q[0] * q[1] >= q[2] * q[2] {
        return Relaxed { stress: q, energy: 0.5 * (q[0] * e[0] + q[1] * e[1] + q[2] * e[2]) };
    }
    if e[0] + e[1] <= 0.0 && 4.0 * e[0] * e[1] >= e[2] * e[2] {
        return Relaxed { stress: [0.0; 3], energy: 0.0 };
    }
    let mut d = [1.0, 0.0];
    let (mut best_gain, mut t) = (0.0, d);
    for _ in 0..DIRECTIONS {
        let Uniaxial { stretch, compliance } = uniaxial(c, e, d);
        let gain = if stretch > 0.0 { stretch * stretch / compliance } else { 0.0 };
        (best_gain, t) = if gain > best_gain { (gain, d) } else { (best_gain, t) };
        d = [STEP[0] * d[0] - STEP[1] * d[1], STEP[0] * d[1] + STEP[1] * d[0]];
    }
    // Bisection of the gain's derivative along t + x n. The gain does not depend on the length of the direction.
    let at = |x: f64| [t[0] - x * t[1], t[1] + x * t[0]];
    let tangent = STEP[1] / STEP[0];
    let (mut low, mut high) = (-tangent, tangent);
    for _ in 0..BISECTIONS {
        let x = 0.5 * (low + high);
        let (d, n) = (at(x), [-t[1], t[0]]);
        let Uniaxial { stretch, compliance } = uniaxial(c, e, d);
        let stretch_slope = 2.0 * (e[0] * d[0] * n[0] + e[1] * d[1] * n[1]) + e[2] * (d[0] * n[1] + d[1] * n[0]);
        let line = [d[0] * d[0], d[1] * d[1], d[0] * d[1]];
        let line_slope = [2.0 * d[0] * n[0], 2.0 * d[1] * n[1], d[0] * n[1] + d[1] * n[0]];
        let compliance_slope = 2.0 * c.compliance_product(line, line_slope);
        let rises = if stretch > 0.0 { 2.0 * stretch_slope * compliance > stretch * compliance_slope } else { x < 0.0 };
        (low, high) = if rises { (x, high) } else { (low, x) };
    }
    let d = at(0.5 * (low + high));
    let Uniaxial { stretch, compliance } = uniaxial(c, e, d);
    let pull = stretch.max(0.0) / compliance;
    Relaxed { stress: [pull * d[0] * d[0], pull * d[1] * d[1], pull * d[0] * d[1]], energy: 0.5 * pull * stretch }
}

/// Strain and compliance along a direction, each times a power of the direction's length.
struct Uniaxial {
    /// Strain times the squared length.
    stretch: f64,
    /// Compliance times the fourth power of the length, m/N.
    compliance: f64,
}

/// Strain and compliance along `d` at the strain `e`.
fn uniaxial(c: &ElasticityTensor, e: Voigt, d: Vec2) -> Uniaxial {
    let line = [d[0] * d[0], d[1] * d[1], d[0] * d[1]];
    Uniaxial { stretch: contract(e, line), compliance: c.compliance_product(line, line) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stress_is_the_energy_derivative_and_has_no_compression() {
        let c = ElasticityTensor::from_moduli(1000.0, 60.0, 0.9, 25.0).unwrap();
        let mut uniaxial_states = 0;
        for i in 0..400 {
            let wave = |k: f64| 0.05 * (k * f64::from(i) + k).sin();
            let e = [wave(1.7), wave(2.9), 2.0 * wave(0.7)];
            let Relaxed { stress, energy } = relax(&c, e);
            let unrelaxed = c.stress(e);
            assert!(energy <= 0.5 * contract(unrelaxed, e) + 1e-12);
            let is_tension = stress[0] + stress[1] >= 0.0 && stress[0] * stress[1] - stress[2] * stress[2] >= -1e-9;
            assert!(is_tension, "{e:?}: {stress:?}");
            uniaxial_states += usize::from(stress != unrelaxed && stress != [0.0; 3]);
            for k in 0..3 {
                let energy_at = |step: f64| {
                    let mut e = e;
                    e[k] += step;
                    relax(&c, e).energy
                };
                let slope = (energy_at(1e-7) - energy_at(-1e-7)) / 2e-7;
                assert!((slope - stress[k]).abs() < 1e-4, "{e:?} {k}: {slope} {}", stress[k]);
            }
        }
        assert!(uniaxial_states > 100, "{uniaxial_states}");
    }

    #[test]
    fn narrowing_under_tension_along_the_warp_costs_no_energy() {
        let c = ElasticityTensor::from_moduli(1000.0, 500.0, 0.3, 50.0).unwrap();
        let Relaxed { stress, energy } = relax(&c, [0.01, -0.02, 0.0]);
        assert!((stress[0] - 10.0).abs() < 1e-9 && stress[1].abs() < 1e-9, "{stress:?}");
        assert!((energy - 0.05).abs() < 1e-12, "{energy}");
    }
}
