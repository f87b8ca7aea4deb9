//! The last stage a torque passes before it reaches a device that drives six axes.
//!
//! A torque is taken for the force at a lever, as long as the device's peak torque is over its peak force, and a rotation for the path of the
//! lever's end. So a torque has the limits, the thermal budget, the slew rate and the passivity of a force, each times the lever, and
//! energy that the rotation generates is observed and damped by itself: translation does not pay for it.

use super::{Cause, ForceLimits, ForceSafety, HandState, Passivity};
use pliant_solver::Vec3;

/// Torque safety of one effector.
#[derive(Clone, Debug)]
pub struct TorqueSafety {
    /// Peak torque over peak force, m.
    lever: f64,
    /// Safety of the force at the lever.
    at_lever: ForceSafety,
}

/// How a live hand turns, at a tick of the haptic loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandTurn {
    /// Sum of the hand's rotation vectors so far, in the axes of the torque, rad.
    pub rotation: Vec3,
    /// Age of the hand sample behind the latest simulation result, s.
    pub age: f64,
}

impl TorqueSafety {
    /// Safety for a device with the peak torque `peak_torque` (N m) and these limits of its force; `None` if the device states no torque.
    pub fn new(peak_torque: f64, limits: ForceLimits) -> Option<Self> {
        let lever = peak_torque / limits.peak;
        (lever.is_finite() && lever > 0.0).then(|| Self { lever, at_lever: ForceSafety::new(limits) })
    }

    /// Adds a passivity observer and controller, for a hand that turns in response to the torque. `passivity` is that of the force at the lever.
    pub fn with_passivity(self, passivity: Passivity) -> Self {
        Self { at_lever: self.at_lever.with_passivity(passivity), ..self }
    }

    /// The largest torque, N m.
    pub fn peak(&self) -> f64 {
        self.lever * self.at_lever.limits().peak
    }

    /// The limits of the force of which the torque is one, see [`TorqueSafety::new`].
    pub fn limits(&self) -> ForceLimits {
        self.at_lever.limits()
    }

    /// Energy balance of the rotation, J, as [`ForceSafety::energy`].
    pub fn energy(&self) -> f64 {
        self.at_lever.energy()
    }

    /// Returns the torque to apply, N m, `dt` (s) after the last, without staleness and passivity checks.
    pub fn pass(&mut self, wanted: Vec3, dt: f64) -> Vec3 {
        self.lever * self.at_lever.pass(wanted / self.lever, dt)
    }

    /// Returns the torque to apply to a live hand, N m, `dt` (s) after the last.
    pub fn pass_live(&mut self, wanted: Vec3, hand: HandTurn, dt: f64) -> Vec3 {
        let hand = HandState { position: self.lever * hand.rotation, age: hand.age, compliance: 0.0 };
        self.lever * self.at_lever.pass_live(wanted / self.lever, hand, dt)
    }

    /// Sets the torque to zero at once, as [`ForceSafety::release`].
    pub fn release(&mut self) {
        self.at_lever.release();
    }

    /// Goes on from another torque safety of the same effector, as [`ForceSafety::resume`]; `factor` is a torque of this one over the same torque of that one.
    pub fn resume(&mut self, before: &Self, factor: f64) {
        self.at_lever.resume(&before.at_lever, factor * before.lever / self.lever);
    }

    /// Number of torques each cause has changed.
    pub fn counts(&self) -> impl Iterator<Item = (Cause, u64)> + '_ {
        self.at_lever.counts()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: ForceLimits = ForceLimits { peak: 3.0, continuous: 1.0, slew: 600.0 };
    /// Largest torque of the tests, N m.
    const PEAK: f64 = 0.3;

    fn safety() -> TorqueSafety {
        TorqueSafety::new(PEAK, LIMITS).expect("a torque")
    }

    fn count(safety: &TorqueSafety, cause: Cause) -> u64 {
        safety.counts().find(|(c, _)| *c == cause).expect("each cause").1
    }

    #[test]
    fn torques_are_finite_and_within_peak_and_slew() {
        let (mut safety, mut last) = (safety(), Vec3::zeros());
        for wanted in [[f64::NAN, 0.0, 0.0], [1e9, -1e9, 0.0], [f64::INFINITY, 1.0, 1.0], [f64::MAX, f64::MAX, 0.0]] {
            for _ in 0..20 {
                let torque = safety.pass(wanted.into(), 1e-3);
                // 600 N/s times 0.1 m, in a millisecond.
                assert!(
                    torque.norm() <= PEAK + 1e-12 && (torque - last).norm() <= 0.06 + 1e-12,
                    "{wanted:?} {torque:?}"
                );
                last = torque;
            }
        }
        // At the lever of 0.1 m the largest number overflows.
        assert!(count(&safety, Cause::NotFinite) == 60 && count(&safety, Cause::Magnitude) == 20);
        let small = Vec3::new(0.01, -0.02, 0.03);
        (0..20).for_each(|_| last = safety.pass(small, 1e-3));
        assert!((last - small).norm() < 1e-15, "a small torque is unchanged: {last:?}");
    }

    #[test]
    fn the_mean_torque_stays_within_the_continuous_rating() {
        let mut safety = safety();
        let squares: Vec<f64> = (0..60_000).map(|_| safety.pass(Vec3::x() * PEAK, 1e-3).norm_squared()).collect();
        assert!((squares[500].sqrt() - PEAK).abs() < 1e-12, "for a moment it has the whole peak");
        let mean = (squares[50_000..].iter().sum::<f64>() / 1e4).sqrt();
        // A third of the peak, as the continuous force is of the peak force.
        assert!((mean - 0.1).abs() < 2e-3, "{mean} N m");
    }

    #[test]
    fn a_torque_of_a_silent_simulation_is_zero_after_150_ms() {
        let mut safety = safety();
        let mut given =
            |age| safety.pass_live(Vec3::z() * 0.1, HandTurn { rotation: Vec3::zeros(), age }, 1e-2).norm() / 0.1;
        let found = [0.0, 0.049, 0.1, 0.151, 60.0].map(&mut given);
        assert!(
            found.iter().zip([1.0, 1.0, 0.5, 0.0, 0.0]).all(|(a, b): (&f64, f64)| (a - b).abs() < 1e-12),
            "{found:?}"
        );
        assert_eq!(count(&safety, Cause::Stale), 3);
    }

    /// A hand that turns to and fro against a torsion spring of 1 N m/rad whose torque is late by `delay` samples. Returns the work of the torque on
    /// the hand, J, and how often it was damped.
    fn oscillate(delay: usize, controls: bool) -> (f64, u64) {
        // At the lever of 0.1 m: 100 N/m, with the damping of a force's test.
        let mut passivity = Passivity::new(5.0, 0.0, 0.05);
        passivity.controls = controls;
        let mut safety = safety().with_passivity(passivity);
        let angle = |k: usize| 1e-2 * (k as f64 * 0.2).sin();
        let (mut work, mut torque) = (0.0, 0.0);
        for k in delay..20_000 {
            work += torque * (angle(k) - angle(k - 1));
            let hand = HandTurn { rotation: Vec3::x() * angle(k), age: 0.0 };
            torque = safety.pass_live(Vec3::x() * -angle(k - delay), hand, 1e-3)[0];
        }
        (work, count(&safety, Cause::Passivity))
    }

    #[test]
    fn a_late_torsion_spring_gives_no_energy() {
        let (work, damped) = oscillate(3, false);
        assert!(work > 0.05 && damped == 0, "without control it makes {work} J");
        let (work, damped) = oscillate(3, true);
        assert!(work < 1e-3 && damped > 100, "with control {work} J, damped {damped} times");
    }

    #[test]
    fn a_device_that_states_no_torque_has_none() {
        for peak in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(TorqueSafety::new(peak, LIMITS).is_none(), "{peak}");
        }
        assert!((safety().peak() - PEAK).abs() < 1e-15);
    }
}
