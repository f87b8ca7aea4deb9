//! The fibre energy of Holzapfel, Gasser and Ogden (2000): `psi(I4) = k1 / (2 k2) (exp(k2 E^2) - 1)` with `E = <I4 - 1>`, I4 the squared stretch
//! along the fibres, and `<x>` = x where it is positive, else 0, so that fibres carry tension alone. The limit `k2 = 0` is the standard
//! reinforcing model `k1 / 2 E^2` (Qiu and Pence 1997).
//!
//! Deviations: I4 is that of F, not of its isochoric part, under which fibres would resist a pure change of volume (Sansour 2008). Where the
//! exponent exceeds [`LARGEST_EXPONENT`] the energy goes on as its quadratic continuation in E, with the same value, slope and curvature, so
//! that it is finite for every F. At rest, where the curvature jumps, fibres count as taut, so that step limits and first iterations know them.

use pliant_plugin_api::solids::FibreEnergy;

/// Exponent `k2 E^2` up to which the law is exponential: the stress is then 5e8 times that without stiffening, beyond what any fibre bears.
const LARGEST_EXPONENT: f64 = 20.0;

/// Strain E above which the curvature counts: below 0 by more than rounding at rest.
const TAUT: f64 = -1e-9;

/// Constants of the fibres of a material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FibreLaw {
    /// Stiffness k1, Pa.
    stiffness: f64,
    /// Stiffening k2 (1).
    stiffening: f64,
    /// Strain E at which the continuation begins.
    last_strain: f64,
}

impl FibreLaw {
    /// The law with stiffness k1 (Pa) and stiffening k2 (1), neither below 0.
    pub(crate) fn new(stiffness: f64, stiffening: f64) -> Self {
        // Without stiffening the exponent is 0 at every strain, and this is infinite.
        Self { stiffness, stiffening, last_strain: (LARGEST_EXPONENT / stiffening).sqrt() }
    }

    /// The energy at a squared stretch I4 along the fibres.
    pub(crate) fn energy(&self, squared_stretch: f64) -> FibreEnergy {
        let strain = squared_stretch - 1.0;
        if strain <= 0.0 {
            return if strain > TAUT { self.exponential(0.0) } else { FibreEnergy::default() };
        }
        if strain <= self.last_strain || strain.is_nan() {
            return self.exponential(strain);
        }
        let (last, beyond) = (self.exponential(self.last_strain), strain - self.last_strain);
        FibreEnergy {
            density: last.density + beyond * (last.slope + 0.5 * beyond * last.curvature),
            slope: last.slope + beyond * last.curvature,
            curvature: last.curvature,
        }
    }

    /// The energy at a strain E of 0 or above.
    fn exponential(&self, strain: f64) -> FibreEnergy {
        let exponent = self.stiffening * strain * strain;
        let growth = libm::expm1(exponent);
        // Its limit is 1 where nothing stiffens.
        let mean = if exponent == 0.0 { 1.0 } else { growth / exponent };
        let tangent = self.stiffness * (1.0 + growth);
        FibreEnergy {
            density: 0.5 * self.stiffness * strain * strain * mean,
            slope: strain * tangent,
            curvature: (1.0 + 2.0 * exponent) * tangent,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slope_and_curvature_are_derivatives_and_the_continuation_is_smooth() {
        for stiffening in [0.0, 0.1, 1.0, 40.0, 1000.0] {
            let law = FibreLaw::new(2.5e3, stiffening);
            let last = if stiffening > 0.0 { law.last_strain } else { 1.0 };
            for strain in [0.3 * last, 0.9 * last, 1.1 * last, 3.0 * last] {
                let h = 1e-4 * last;
                let at = |by: f64| law.energy(1.0 + strain + by);
                let slope = (at(h).density - at(-h).density) / (2.0 * h);
                let curvature = (at(h).slope - at(-h).slope) / (2.0 * h);
                let FibreEnergy { slope: s, curvature: c, .. } = at(0.0);
                assert!((slope / s - 1.0).abs() < 1e-5, "{stiffening} {strain}: {slope} {s}");
                assert!((curvature / c - 1.0).abs() < 1e-5, "{stiffening} {strain}: {curvature} {c}");
            }
            if stiffening > 0.0 {
                let [before, after] = [-1e-9, 1e-9].map(|by| law.energy(1.0 + last + by));
                for (a, b) in
                    [(before.density, after.density), (before.slope, after.slope), (before.curvature, after.curvature)]
                {
                    assert!((a / b - 1.0).abs() < 1e-4, "{stiffening}: {before:?} {after:?}");
                }
            }
        }
    }

    #[test]
    fn fibres_are_slack_in_compression_and_finite_at_any_stretch() {
        for stiffening in [0.0, 1.0, 1000.0] {
            let law = FibreLaw::new(1e12, stiffening);
            assert!([0.0, 0.5, 1.0 - 1e-6].map(|i4| law.energy(i4)).iter().all(|e| *e == FibreEnergy::default()));
            assert_eq!(law.energy(1.0), FibreEnergy { density: 0.0, slope: 0.0, curvature: 1e12 });
            let FibreEnergy { density, slope, curvature } = law.energy(1e8);
            assert!(
                [density, slope, curvature].iter().all(|v| v.is_finite() && *v > 0.0),
                "{density} {slope} {curvature}"
            );
        }
    }

    #[test]
    fn little_stiffening_tends_to_the_standard_reinforcing_model() {
        let (with, without) = (FibreLaw::new(1e4, 1e-9).energy(1.5), FibreLaw::new(1e4, 0.0).energy(1.5));
        assert!((without.density - 0.5e4 * 0.25).abs() < 1e-9 && (without.slope - 0.5e4).abs() < 1e-9);
        assert!((with.density / without.density - 1.0).abs() < 1e-8, "{with:?} {without:?}");
    }
}
