//! Damage by the largest strain.

/// Least distance of the strain at which damage is complete from the one at which it begins, over that one: a triangle too wide for its fracture
/// energy.
const BRITTLE: f64 = 1e-3;
/// Most iterations for the strain at which damage begins: Newton's method on a cubic, from above.
const MAX_ITERATIONS: usize = 200;

/// A nominal stress that falls linearly with the strain, the principal stretch less 1.
#[derive(Clone, Copy, Debug)]
pub struct Softening {
    /// Strain at which damage begins.
    pub begin: f64,
    /// Strain at which it is complete.
    pub end: f64,
}

/// Nominal stress of an undamaged triangle stretched by the strain `e` along one axis, over Young's modulus: Green's strain times the stretch.
fn nominal(e: f64) -> f64 {
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

impl Softening {
    /// Of a band of width `width` (m) with Young's modulus `young` (Pa), tensile strength `strength` (Pa) and fracture energy `energy` (J/m^2).
    pub fn new(young: f64, strength: f64, energy: f64, width: f64) -> Self {
        let begin = strain_of(strength / young);
        let green = 0.5 * begin * (2.0 + begin);
        let elastic = 0.5 * young * green * green;
        let end = begin + 2.0 * (energy / width - elastic) / strength;
        Self { begin, end: end.max(begin * (1.0 + BRITTLE)) }
    }

    /// The damage, 0 to 1, after the strain `largest`.
    pub fn damage(self, largest: f64) -> f64 {
        if largest <= self.begin {
            return 0.0;
        }
        let falls_to = (self.end - largest).max(0.0) / (self.end - self.begin);
        1.0 - falls_to * nominal(self.begin) / nominal(largest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_work_on_a_band_is_its_fracture_energy_whatever_its_width() {
        let (young, strength, energy) = (2e6, 1e5, 150.0);
        for width in [1e-4, 1e-3, 1e-2, 2.9e-2] {
            let softening = Softening::new(young, strength, energy, width);
            assert!((young * nominal(softening.begin) / strength - 1.0).abs() < 1e-12);
            let steps = 200_000;
            let stress = |e: f64| (1.0 - softening.damage(e)) * young * nominal(e);
            let at = |i: usize| softening.end * i as f64 / f64::from(steps);
            let work: f64 =
                (0..steps as usize).map(|i| 0.5 * (stress(at(i)) + stress(at(i + 1))) * (at(i + 1) - at(i))).sum();
            assert!((work * width / energy - 1.0).abs() < 1e-4, "{width} m: {} J/m^2", work * width);
            let halfway = 0.5 * (softening.begin + softening.end);
            assert!((stress(halfway) / (0.5 * strength) - 1.0).abs() < 1e-9, "it falls linearly");
        }
        // Too wide for its energy: it takes what it has stored at its strength.
        let brittle = Softening::new(young, strength, energy, 0.2);
        assert!((brittle.end / brittle.begin - 1.0 - BRITTLE).abs() < 1e-9);
    }

    #[test]
    fn damage_grows_from_zero_to_one() {
        let softening = Softening { begin: 0.1, end: 0.5 };
        assert_eq!([0.0, 0.1, 0.5, 9.0].map(|e| softening.damage(e)), [0.0, 0.0, 1.0, 1.0]);
        assert!((0..100).map(|i| softening.damage(0.01 * f64::from(i))).is_sorted());
        for stress in [1e-12, 1e-3, 1.0, 1e6, 1e12] {
            assert!((nominal(strain_of(stress)) / stress - 1.0).abs() < 1e-12, "{stress}");
        }
    }
}
