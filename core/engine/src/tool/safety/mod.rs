//! The last stage a force passes before it reaches a device, whatever plugins computed before.
//!
//! In this order: a force that is not finite becomes zero; a force of a stale simulation result fades; damping is added where the force has
//! generated energy; then the magnitude, the root mean square over ten seconds and the slew rate are limited. Each cause is counted.

mod budget;
mod passivity;
mod stale;
mod torque;

pub use budget::Budget;
pub use passivity::{CouplingLoad, Passivity};
pub use stale::{FADE_TIME, STALE_AFTER, stale_fraction};
pub use torque::{HandTurn, TorqueSafety};

use pliant_solver::Vec3;
use serde::Serialize;

/// Force limits of a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceLimits {
    /// Largest force at any moment, N.
    pub peak: f64,
    /// Largest force that may be applied indefinitely, N.
    pub continuous: f64,
    /// Largest rate of change of the force, N/s.
    pub slew: f64,
}

/// Why force safety changed a force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// A component was NaN or infinite.
    NotFinite,
    /// It was larger than the device's peak.
    Magnitude,
    /// It changed faster than allowed.
    Slew,
    /// Its root mean square over ten seconds came near the continuous rating.
    Continuous,
    /// It had given the hand more energy than the hand had put in.
    Passivity,
    /// The simulation had not answered for [`STALE_AFTER`].
    Stale,
}

impl Cause {
    /// All causes, in the order of their counters.
    pub const ALL: [Self; 6] =
        [Self::NotFinite, Self::Magnitude, Self::Slew, Self::Continuous, Self::Passivity, Self::Stale];

    /// Name of the cause in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "force not finite",
            Self::Magnitude => "force over the device's peak",
            Self::Slew => "force changed too fast",
            Self::Continuous => "force over the device's continuous rating",
            Self::Passivity => "force made energy",
            Self::Stale => "force of a silent simulation",
        }
    }
}

/// State of a live hand at a tick of the haptic loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandState {
    /// Position of the hand, in the axes of the force, m.
    pub position: Vec3,
    /// Age of the hand sample behind the latest simulation result, s.
    pub age: f64,
    /// Compliance of the coupling along the force, m/N; 0 if unknown. The coupling stores the energy `compliance * force^2 / 2`.
    pub compliance: f64,
}

/// Force safety of one effector: its limits, the last force applied and the counts of each cause.
#[derive(Clone, Debug)]
pub struct ForceSafety {
    limits: ForceLimits,
    budget: Budget,
    /// `None` for a hand that does not move in response to the force, such as a recording.
    passivity: Option<Passivity>,
    /// Last force applied, N.
    last: Vec3,
    counts: [u64; Cause::ALL.len()],
}

impl ForceSafety {
    /// Force safety with a last force of zero.
    pub fn new(limits: ForceLimits) -> Self {
        let budget = Budget::new(limits.peak, limits.continuous);
        Self { limits, budget, passivity: None, last: Vec3::zeros(), counts: [0; Cause::ALL.len()] }
    }

    /// The limits it enforces.
    pub fn limits(&self) -> ForceLimits {
        self.limits
    }

    /// The last force applied, N.
    pub fn last(&self) -> Vec3 {
        self.last
    }

    /// Energy balance of the passivity observer, J: positive if the hand has put in more than it got back, negative if the force has generated
    /// energy; 0 without an observer.
    pub fn energy(&self) -> f64 {
        self.passivity.as_ref().map_or(0.0, Passivity::energy)
    }

    /// Switches the passivity controller on; off, the observer only measures.
    pub fn control(&mut self, controls: bool) {
        if let Some(passivity) = &mut self.passivity {
            passivity.controls = controls;
        }
    }

    /// Adds a passivity observer and controller, for a hand that moves in response to the force.
    pub fn with_passivity(self, passivity: Passivity) -> Self {
        Self { passivity: Some(passivity), ..self }
    }

    /// Returns the force to apply, N, `dt` (s) after the last, without staleness and passivity checks.
    pub fn pass(&mut self, wanted: Vec3, dt: f64) -> Vec3 {
        self.limit(wanted, None, dt)
    }

    /// Returns the force to apply to a live hand, N, `dt` (s) after the last.
    pub fn pass_live(&mut self, wanted: Vec3, hand: HandState, dt: f64) -> Vec3 {
        self.limit(wanted, Some(hand), dt)
    }

    fn limit(&mut self, wanted: Vec3, hand: Option<HandState>, dt: f64) -> Vec3 {
        let mut force = wanted;
        if !wanted.iter().all(|f| f.is_finite()) {
            self.count(Cause::NotFinite);
            force = Vec3::zeros();
        }
        if let Some(hand) = hand {
            let factor = stale_fraction(hand.age);
            if factor < 1.0 {
                self.count(Cause::Stale);
                force *= factor;
            }
            let applied = force.norm().min(self.limits.peak).min(self.budget.allowed());
            if let Some(passivity) = &mut self.passivity
                && let Some(damping) =
                    passivity.control(hand.position, CouplingLoad { force: applied, compliance: hand.compliance }, dt)
            {
                self.counts[Cause::Passivity as usize] += 1;
                force += damping;
            }
        }
        force = self.clamp_norm(force, self.limits.peak, Cause::Magnitude);
        force = self.clamp_norm(force, self.budget.allowed(), Cause::Continuous);
        let change = force - self.last;
        let (jump, max_jump) = (change.norm(), self.limits.slew * dt);
        if jump > max_jump {
            self.count(Cause::Slew);
            force = self.last + max_jump / jump * change;
        }
        self.budget.record(force, dt);
        if let Some(passivity) = &mut self.passivity {
            passivity.set_applied_force(force);
        }
        self.last = force;
        force
    }

    /// Scales a force down to the magnitude `max`, N, and counts the cause if that changes it.
    fn clamp_norm(&mut self, force: Vec3, max: f64, cause: Cause) -> Vec3 {
        let norm = force.norm();
        if norm <= max {
            return force;
        }
        self.count(cause);
        // A norm that overflows to infinity leaves no usable direction.
        let scale = if norm.is_finite() { max / norm } else { 0.0 };
        force * scale
    }

    fn count(&mut self, cause: Cause) {
        self.counts[cause as usize] += 1;
    }

    /// Sets the force to zero at once, without a slew limit, and resets the energy balance, as when the hand lets go of the device.
    pub fn release(&mut self) {
        self.last = Vec3::zeros();
        if let Some(passivity) = &mut self.passivity {
            passivity.reset();
        }
    }

    /// Goes on from the last force and the heat of the motors of another force safety of the same effector. `factor` is a force of this one over the same force
    /// of that one. The energy balance goes on where forces have the same scale, and is reset otherwise.
    pub fn resume(&mut self, before: &Self, factor: f64) {
        self.last = factor * before.last;
        self.budget.resume(&before.budget, factor);
        if let (Some(now), Some(before), true) = (&mut self.passivity, &before.passivity, factor == 1.0) {
            now.resume(before);
        }
    }

    /// Number of forces each cause has changed.
    pub fn counts(&self) -> impl Iterator<Item = (Cause, u64)> + '_ {
        Cause::ALL.into_iter().map(|cause| (cause, self.counts[cause as usize]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn safety() -> ForceSafety {
        ForceSafety::new(ForceLimits { peak: 3.3, continuous: 3.3, slew: 500.0 })
    }

    fn count(safety: &ForceSafety, cause: Cause) -> u64 {
        safety.counts().find(|(c, _)| *c == cause).unwrap().1
    }

    #[test]
    fn output_is_finite_and_within_limits() {
        let mut safety = safety();
        let mut last = Vec3::zeros();
        for wanted in [
            [f64::NAN, 0.0, 0.0],
            [1e9, -1e9, 0.0],
            [f64::INFINITY, 1.0, 1.0],
            [f64::MAX, f64::MAX, 0.0],
            [0.1, 0.2, 0.3],
            [-3.0, 0.0, 0.0],
        ] {
            let out = safety.pass(wanted.into(), 1e-3);
            let (size, change) = (out.norm(), out - last);
            assert!(size <= 3.3 + 1e-12 && change.norm() <= 0.5 + 1e-12, "{wanted:?} {out:?}");
            last = out;
        }
        assert!(count(&safety, Cause::NotFinite) == 2 && count(&safety, Cause::Magnitude) == 2);
    }

    #[test]
    fn small_forces_are_unchanged_and_large_ones_keep_their_direction() {
        let mut safety = safety();
        assert_eq!(safety.pass(Vec3::new(0.1, -0.2, 0.3), 1e-3), Vec3::new(0.1, -0.2, 0.3));
        let mut out = Vec3::zeros();
        for _ in 0..20 {
            out = safety.pass(Vec3::new(300.0, 400.0, 0.0), 1e-3);
        }
        assert!((out[0] - 1.98).abs() < 1e-12 && (out[1] - 2.64).abs() < 1e-12);
        assert!(count(&safety, Cause::Slew) > 0);
    }

    #[test]
    fn a_stale_force_is_zero_after_150_ms() {
        let mut safety = safety();
        let still = |age| HandState { position: Vec3::zeros(), age, compliance: 0.0 };
        let mut given = |age| safety.pass_live(Vec3::z(), still(age), 1e-2)[2];
        assert_eq!([0.0, 0.049, 0.1, 0.151, 60.0].map(&mut given), [1.0, 1.0, 0.5, 0.0, 0.0]);
        assert_eq!(count(&safety, Cause::Stale), 3);
    }

    #[test]
    fn rms_force_stays_within_the_continuous_rating() {
        let limits = ForceLimits { peak: 3.3, continuous: 0.88, slew: 500.0 };
        let mut safety = ForceSafety::new(limits);
        let mut squares = Vec::new();
        for _ in 0..60_000 {
            let out = safety.pass(Vec3::new(3.3, 0.0, 0.0), 1e-3);
            squares.push(out[0] * out[0]);
        }
        assert!(squares[500] > 10.0, "a short press has the whole peak");
        let mean = |from: usize| (squares[from..from + 10_000].iter().sum::<f64>() / 1e4).sqrt();
        assert!((mean(50_000) - 0.88).abs() < 0.01, "{} N", mean(50_000));
    }
}
