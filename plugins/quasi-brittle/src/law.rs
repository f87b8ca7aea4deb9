//! What damage follows from: an equivalent strain by the elastic energy, tension and compression apart (Oliver, Cervera, Oller and Lubliner 1990).
//!
//! With psi the energy density of an undamaged element and Y Young's modulus, the equivalent strain is `e = (t + (1 - t) / n) sqrt(2 psi / Y)`. Here t is the
//! share of tension in the principal stresses, 1 where all pull and 0 where all press, and n the ratio of compressive to tensile strength. A damage that
//! follows from the energy dissipates `psi dd`, so what an element under tension has dissipated when it fails does not depend on how it got
//! there, nor on what holds its sides.

use pliant_plugin_api::CrackBand;
use pliant_plugin_api::lanes::Vec3;
use pliant_plugin_api::solids::{Mat3, StableNeoHookean, Svd, lame_constants, svd};

/// Halvings of the interval that contains the stretch at which damage begins: to the last bit.
const HALVINGS: usize = 100;
/// Largest square of `|C - I|`, C the right Cauchy-Green tensor, for which the energy is bounded by that of small strains, and the factor of that bound.
const NEAR_REST: f64 = 0.25;
const BOUND: f64 = 2.0;

/// Constants of an element.
#[derive(Clone, Copy, Debug)]
pub struct Constants {
    /// Young's modulus, Pa.
    pub young: f64,
    /// Tensile strength, Pa.
    pub strength: f64,
    /// Fracture energy, J/m^2.
    pub fracture_energy: f64,
}

impl Constants {
    /// The softening over a width (m) of an element whose damage begins at the equivalent strain `begin`.
    pub fn band(&self, begin: f64, width: f64) -> CrackBand {
        let stress = self.young * begin;
        CrackBand::new(begin, 0.5 * stress * begin, stress, self.fracture_energy, width)
    }

    /// The largest width of the element, m.
    pub fn largest_width(&self, begin: f64) -> f64 {
        CrackBand::largest_width(0.5 * self.young * begin * begin, self.fracture_energy)
    }
}

/// The law of a material, for a Young's modulus of 1 Pa: all else is proportional.
pub struct Law {
    unit: StableNeoHookean,
    /// Compressive over tensile strength.
    compression: f64,
    /// Bound of the energy density over the square of `|C - I|`, near rest.
    stiffest: f64,
}

/// The state of an element as damage sees it.
pub struct State {
    /// Equivalent strain (no unit): that of a pulled bar with the same energy, less where the element is pressed.
    pub strain: f64,
    /// Direction at rest of the largest principal stress.
    pub normal: Vec3,
}

impl Law {
    /// The law for Poisson's ratio and the ratio of compressive to tensile strength, 1 or more.
    pub fn new(poisson: f64, compression: f64) -> Self {
        let [shear, first_lame] = lame_constants(1.0, poisson);
        // Of small strains E = (C - I) / 2 the energy is at most (3 lambda / 2 + mu) |E|^2.
        let stiffest = BOUND * (1.5 * first_lame + shear) / 4.0;
        Self { unit: StableNeoHookean::new(shear, first_lame), compression, stiffest }
    }

    /// Square of `|C - I|` up to which the equivalent strain is certainly below `begin`.
    pub fn certainly_elastic(&self, begin: f64) -> f64 {
        NEAR_REST.min(0.5 * begin * begin / self.stiffest)
    }

    /// Equivalent strain of a bar whose nominal stress is `ratio` times Young's modulus.
    pub fn begin(&self, ratio: f64) -> f64 {
        let (mut below, mut above) = (0.0, 1.0);
        while self.unit.bar_stress(1.0 + above) < ratio {
            (below, above) = (above, 2.0 * above);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (below + above);
            match self.unit.bar_stress(1.0 + middle) < ratio {
                true => below = middle,
                false => above = middle,
            }
        }
        let (along, across) = (1.0 + above, self.unit.lateral_stretch(1.0 + above));
        let f = [Vec3([along, 0.0, 0.0]), Vec3([0.0, across, 0.0]), Vec3([0.0, 0.0, across])];
        (2.0 * self.unit.energy(&f)).sqrt()
    }

    /// The state at the deformation gradient `f`.
    pub fn state(&self, f: &Mat3) -> State {
        let Svd { s, v, .. } = svd(f);
        let stress = self.unit.stress(&[Vec3([s[0], 0.0, 0.0]), Vec3([0.0, s[1], 0.0]), Vec3([0.0, 0.0, s[2]])]);
        let stresses = [stress[0][0], stress[1][1], stress[2][2]];
        let (pull, all) =
            stresses.iter().fold((0.0, 0.0), |(pull, all), stress| (pull + stress.max(0.0), all + stress.abs()));
        let tension = if all > 0.0 { pull / all } else { 0.0 };
        let weight = tension + (1.0 - tension) / self.compression;
        // Rounding at rest may leave it below zero.
        let strain = weight * (2.0 * self.unit.energy(f)).max(0.0).sqrt();
        State { strain, normal: Vec3([v[0][0], v[1][0], v[2][0]]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_plugin_api::kit::Random;

    fn diagonal(s: [f64; 3]) -> Mat3 {
        [Vec3([s[0], 0.0, 0.0]), Vec3([0.0, s[1], 0.0]), Vec3([0.0, 0.0, s[2]])]
    }

    #[test]
    fn damage_begins_at_the_strength_of_a_bar() {
        for poisson in [0.0, 0.2, 0.45, 0.499] {
            let law = Law::new(poisson, 10.0);
            for ratio in [1e-4, 1e-2, 0.1, 1.0, 30.0] {
                let begin = law.begin(ratio);
                // The bar whose energy that is: its stress, and the work up to there.
                let stored = |stretch: f64| {
                    let across = law.unit.lateral_stretch(stretch);
                    let f = diagonal([stretch, across, across]);
                    assert!(
                        law.unit.stress(&f)[1][1].abs() < 1e-10 * (1.0 + stretch * stretch),
                        "nothing holds its sides"
                    );
                    assert!((law.unit.stress(&f)[0][0] - law.unit.bar_stress(stretch)).abs() < 1e-10 * (1.0 + stretch));
                    law.unit.energy(&f)
                };
                let (mut strain, target) = (ratio, 0.5 * begin * begin);
                for _ in 0..200 {
                    strain -= (stored(1.0 + strain) - target) / law.unit.bar_stress(1.0 + strain);
                }
                let error = law.unit.bar_stress(1.0 + strain) / ratio - 1.0;
                assert!(error.abs() < 1e-5, "{poisson} {ratio}: {error}");
                let steps = 20_000;
                let width = strain / f64::from(steps);
                let work: f64 =
                    (0..steps).map(|i| law.unit.bar_stress(1.0 + (f64::from(i) + 0.5) * width) * width).sum();
                assert!((work / target - 1.0).abs() < 1e-5, "{poisson} {ratio}: {work} of {target}");
                // Small strains follow Hooke's law.
                assert!(ratio > 1e-2 || (begin / ratio - 1.0).abs() < 3.0 * ratio, "{begin}");
            }
        }
    }

    #[test]
    fn nothing_near_rest_is_left_out() {
        let mut random = Random(4);
        for poisson in [0.0, 0.2, 0.45, 0.499] {
            let law = Law::new(poisson, 1.0);
            for _ in 0..20_000 {
                let size = 10.0_f64.powf(-4.0 * random.vector()[0].abs());
                let mut f: Mat3 = [(); 3].map(|()| Vec3(random.vector()) * size);
                (0..3).for_each(|i| f[i][i] += 1.0);
                let columns: Mat3 = [0, 1, 2].map(|j| Vec3([0, 1, 2].map(|i| f[i][j])));
                let entry = |i: usize, j: usize| columns[i].dot(columns[j]) - f64::from(u8::from(i == j));
                let distance: f64 = (0..9).map(|k| entry(k / 3, k % 3).powi(2)).sum();
                let strain = law.state(&f).strain;
                // Whatever the strength is: the least `begin` that would leave it out is above the strain.
                let least = (2.0 * law.stiffest * distance).sqrt();
                // Rounding of an energy that is a difference of numbers near the bulk modulus.
                let rounding = 1e-7 / (1.0 - 2.0 * poisson).sqrt();
                assert!(distance > NEAR_REST || strain <= least + rounding, "{poisson}: {strain} {least} {f:?}");
            }
        }
    }

    #[test]
    fn what_is_pressed_is_as_many_times_as_strong() {
        for compression in [1.0, 10.0] {
            let law = Law::new(0.2, compression);
            let [pulled, pressed] = [1.001, 0.999].map(|stretch| {
                let across = law.unit.lateral_stretch(stretch);
                law.state(&diagonal([across, stretch, across])).strain
            });
            assert!((pulled / pressed / compression - 1.0).abs() < 0.02, "{pulled} {pressed}");
        }
        let law = Law::new(0.2, 10.0);
        let normal = law.state(&diagonal([1.0, 0.9, 1.2])).normal;
        assert!(normal[2].abs() > 1.0 - 1e-12, "{normal:?}");
    }
}
