//! Softening of an element through which a crack passes: the crack band model of Bažant and Oh (1983), for materials that fail.

/// Least distance of the strain at which damage is complete from the one at which it begins, over that one: an element too wide for its fracture
/// energy.
const BRITTLE: f64 = 1e-3;

/// A nominal stress that falls linearly with the strain, the principal stretch less 1, from the strength to zero. The work on an element of the width for
/// which it was made is its fracture energy for each area of a crack across the width, whatever the width is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrackBand {
    /// Strain at which damage begins.
    pub begin: f64,
    /// Strain at which it is complete.
    pub end: f64,
}

impl CrackBand {
    /// An element whose nominal stress comes to `strength` (Pa) at the strain `begin`, where it has stored `elastic` (J/m^3), with a fracture energy of
    /// `energy` (J/m^2) over a width of `width` (m). One that has stored more than that fails at once and takes what it has stored.
    pub fn new(begin: f64, elastic: f64, strength: f64, energy: f64, width: f64) -> Self {
        let end = begin + 2.0 * (energy / width - elastic) / strength;
        Self { begin, end: end.max(begin * (1.0 + BRITTLE)) }
    }

    /// The damage, 0 to 1, after the strain `largest`; `nominal` gives the nominal stress of an undamaged element at a strain, in any unit.
    pub fn damage(self, largest: f64, nominal: impl Fn(f64) -> f64) -> f64 {
        if largest <= self.begin {
            return 0.0;
        }
        let falls_to = (self.end - largest).max(0.0) / (self.end - self.begin);
        1.0 - falls_to * nominal(self.begin) / nominal(largest)
    }

    /// The largest width (m) of an element whose fracture energy is `energy` (J/m^2), where it stores `elastic` (J/m^3) up to its strength: wider ones
    /// store more than a crack takes (snap-back). About `2 G E / f^2` with Young's modulus E and strength f.
    pub fn largest_width(elastic: f64, energy: f64) -> f64 {
        energy / elastic
    }
}

/// Elements that are too wide for their fracture energy, counted as they are met.
#[derive(Clone, Copy, Debug, Default)]
pub struct TooWide {
    /// Number of elements that were met.
    count: usize,
    /// Number of those that are too wide.
    too_wide: usize,
    /// Width of the one that exceeds its largest width by the greatest factor, and that largest width, m.
    worst: [f64; 2],
}

impl TooWide {
    /// Takes account of an element of `width` (m), which may be as wide as `largest` (m).
    pub fn meet(&mut self, width: f64, largest: f64) {
        self.count += 1;
        self.too_wide += usize::from(width > largest);
        if width * self.worst[1] > largest * self.worst[0] || self.count == 1 {
            self.worst = [width, largest];
        }
    }

    /// A warning for people that calls the elements `elements`, such as `triangles`; `None` where none is too wide.
    pub fn warning(&self, elements: &str) -> Option<String> {
        let [width, largest] = self.worst;
        (self.too_wide > 0).then(|| {
            format!(
                "{} of {} {elements} are too wide for their fracture energy: a crack across their longest side fails them at once and takes more; up to {width:.3e} m, allowed \
                 {largest:.3e} m (2 fracture-energy young / strength^2); refine, or lower strength",
                self.too_wide, self.count
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg_attr(miri, ignore = "sums millions of steps")]
    fn the_work_on_a_band_is_its_fracture_energy_whatever_its_width() {
        // Hooke's law and one that stiffens.
        type Law = (fn(f64) -> f64, f64, f64);
        let laws: [Law; 2] = [(|e| 2e6 * e, 0.05, 0.5 * 2e6 * 0.0025), (|e| 2e6 * e * e, 0.2, 2e6 * 0.008 / 3.0)];
        for (nominal, begin, elastic) in laws {
            let (strength, energy) = (nominal(begin), 150.0);
            let most = CrackBand::largest_width(elastic, energy);
            for width in [1e-4, 1e-3, 1e-2, 0.99 * most] {
                let band = CrackBand::new(begin, elastic, strength, energy, width);
                let stress = |e: f64| (1.0 - band.damage(e, nominal)) * nominal(e);
                let steps = 200_000;
                let at = |i: usize| band.end * i as f64 / f64::from(steps);
                let work: f64 =
                    (0..steps as usize).map(|i| 0.5 * (stress(at(i)) + stress(at(i + 1))) * (at(i + 1) - at(i))).sum();
                assert!((work * width / energy - 1.0).abs() < 1e-4, "{width} m: {} J/m^2", work * width);
                let halfway = 0.5 * (band.begin + band.end);
                assert!((stress(halfway) / (0.5 * strength) - 1.0).abs() < 1e-9, "it falls linearly");
                assert!(stress(band.end) == 0.0 && band.damage(band.end, nominal) == 1.0, "it comes to nothing");
            }
            // Too wide for its energy: it takes what it has stored at its strength.
            let brittle = CrackBand::new(begin, elastic, strength, energy, 3.0 * most);
            assert!((brittle.end / brittle.begin - 1.0 - BRITTLE).abs() < 1e-9);
        }
    }

    #[test]
    fn damage_grows_from_zero_to_one() {
        let band = CrackBand { begin: 0.1, end: 0.5 };
        assert_eq!([0.0, 0.1, 0.5, 9.0].map(|e| band.damage(e, |e| e)), [0.0, 0.0, 1.0, 1.0]);
        assert!((0..100).map(|i| band.damage(0.01 * f64::from(i), |e| e)).is_sorted());
    }

    #[test]
    fn a_warning_names_the_worst() {
        let mut met = TooWide::default();
        [(0.01, 0.02), (0.02, 0.02), (0.05, 0.01), (0.06, 0.02)]
            .into_iter()
            .for_each(|(width, largest)| met.meet(width, largest));
        let text = met.warning("triangles").expect("two are too wide");
        assert!(text.starts_with("2 of 4 triangles") && text.contains("5.000e-2 m, allowed 1.000e-2 m"), "{text}");
        assert!(text.len() < 255, "the host keeps all of it");
        let mut met = TooWide::default();
        met.meet(0.02, 0.02);
        assert_eq!(met.warning("triangles"), None);
    }
}
