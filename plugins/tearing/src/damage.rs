//! Damage by the largest strain: the crack band of a St. Venant-Kirchhoff membrane.

use pliant_plugin_api::CrackBand;

/// Most iterations for the strain at which damage begins: Newton's method on a cubic, from above.
const MAX_ITERATIONS: usize = 200;

/// Nominal stress of an undamaged triangle stretched by the strain `e` along one axis, over Young's modulus: Green's strain times the stretch.
pub fn nominal(e: f64) -> f64 {
    0.5 * e * (1.0 + e) * (2.0 + e)
}

/// The strain at which an undamaged triangle has the nominal stress `stress` over Young's modulus.
fn strain_of(stress: f64) -> f64 {
    let mut e = stress;
    for _ in 0..MAX_ITERATIONS {
        let next = e - (nominal(e) - stress) / (1.0 + e * (3.0 + 1.5 * e));
        if next >= e {
            break;
        }
        e = next;
    }
    e
}

/// Strength of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Strength {
    /// Tensile strength, Pa.
    stress: f64,
    /// Strain at which it is reached.
    strain: f64,
    /// What is stored then, J/m^3.
    elastic: f64,
}

impl Strength {
    /// A tensile strength of `strength` (Pa) with Young's modulus `young` (Pa).
    pub fn new(young: f64, strength: f64) -> Self {
        let strain = strain_of(strength / young);
        let green = 0.5 * strain * (2.0 + strain);
        Self { stress: strength, strain, elastic: 0.5 * young * green * green }
    }

    /// The softening of a band of width `width` (m) with the fracture energy `energy` (J/m^2).
    pub fn band(self, energy: f64, width: f64) -> CrackBand {
        CrackBand::new(self.strain, self.elastic, self.stress, energy, width)
    }

    /// The largest width (m) of a triangle with the fracture energy `energy` (J/m^2).
    pub fn largest_width(self, energy: f64) -> f64 {
        CrackBand::largest_width(self.elastic, energy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strength_is_reached_at_its_strain() {
        for stress in [1e-12, 1e-3, 1.0, 1e6, 1e12] {
            assert!((nominal(strain_of(stress)) / stress - 1.0).abs() < 1e-12, "{stress}");
        }
        let (young, strength, energy) = (2e6, 1e5, 150.0);
        let of = Strength::new(young, strength);
        // The elastic energy is the integral of the stress.
        let (steps, mut stored) = (100_000, 0.0);
        for i in 0..steps {
            stored +=
                young * nominal(of.strain * (f64::from(i) + 0.5) / f64::from(steps)) * of.strain / f64::from(steps);
        }
        assert!((stored / of.elastic - 1.0).abs() < 1e-8);
        let most = of.largest_width(energy);
        assert!((most / (2.0 * energy * young / (strength * strength)) - 1.0).abs() < 0.1, "{most} m");
        assert!(
            of.band(energy, 0.9 * most).end > 1.01 * of.strain && of.band(energy, 1.1 * most).end < 1.01 * of.strain
        );
    }
}
