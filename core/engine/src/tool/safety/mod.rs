//! The last thing a force passes before it reaches a hand, whatever the plugins before it did.
//!
//! In order: not finite becomes zero; a force whose simulation has gone silent fades; one that has made energy is damped; then
//! its magnitude, its mean over ten seconds and its change per time are cut. Each cause has a counter.

mod budget;
mod passivity;
mod stale;

pub use budget::Budget;
pub use passivity::{Load, Passivity};
pub use stale::{FADES, PATIENCE, fresh};

use pliant_solver::Vec3;
use serde::Serialize;

/// What a device may be given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceLimits {
    /// Peak, N.
    pub peak: f64,
    /// Largest force that may be given without end, N.
    pub continuous: f64,
    /// N/s
    pub slew: f64,
}

/// Why a force was changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// It held a value that is not finite.
    NotFinite,
    /// It was larger than the device's peak.
    Magnitude,
    /// It changed faster than allowed.
    Slew,
    /// Its mean over ten seconds came near what the device bears.
    Continuous,
    /// It had given the hand more energy than it took.
    Passivity,
    /// The simulation behind it was silent.
    Stale,
}

impl Cause {
    /// All of them, in order of their counters.
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

/// What a live hand knows besides the force that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The hand, in the axes of the force, m.
    pub position: Vec3,
    /// Time since the sample of the hand that the simulation last answered, s.
    pub age: f64,
    /// Compliance of the coupling along the force: it holds half of it times the square of the force; 0 where that is not known, m/N.
    pub compliance: f64,
}

/// The force last given to one effector, and what was changed on the way.
#[derive(Clone, Debug)]
pub struct ForceSafety {
    limits: ForceLimits,
    budget: Budget,
    passivity: Option<Passivity>,
    last: Vec3,
    counts: [u64; Cause::ALL.len()],
}

impl ForceSafety {
    /// Force safety with a last force of zero.
    pub fn new(limits: ForceLimits) -> Self {
        let budget = Budget::new(limits.peak, limits.continuous);
        Self { limits, budget, passivity: None, last: Vec3::zeros(), counts: [0; Cause::ALL.len()] }
    }

    /// What it lets through.
    pub fn limits(&self) -> ForceLimits {
        self.limits
    }

    /// The force last given, N.
    pub fn last(&self) -> Vec3 {
        self.last
    }

    /// What the hand has given and not got back, where that is observed; below zero: made by the force, J.
    pub fn energy(&self) -> f64 {
        self.passivity.as_ref().map_or(0.0, Passivity::energy)
    }

    /// Whether the controller of passivity acts, or the observer only watches.
    pub fn control(&mut self, controls: bool) {
        if let Some(passivity) = &mut self.passivity {
            passivity.controls = controls;
        }
    }

    /// The same, with an observer of energy: for a hand that gives way.
    pub fn observed(self, passivity: Passivity) -> Self {
        Self { passivity: Some(passivity), ..self }
    }

    /// The force to give, N, `dt` (s) after the last, where nothing is known of the hand.
    pub fn pass(&mut self, wanted: Vec3, dt: f64) -> Vec3 {
        self.chain(wanted, None, dt)
    }

    /// The force to give to a live hand, N, `dt` (s) after the last.
    pub fn pass_live(&mut self, wanted: Vec3, moment: Moment, dt: f64) -> Vec3 {
        self.chain(wanted, Some(moment), dt)
    }

    fn chain(&mut self, wanted: Vec3, moment: Option<Moment>, dt: f64) -> Vec3 {
        let mut force = wanted;
        if !wanted.iter().all(|f| f.is_finite()) {
            self.count(Cause::NotFinite);
            force = Vec3::zeros();
        }
        if let Some(moment) = moment {
            let share = fresh(moment.age);
            if share < 1.0 {
                self.count(Cause::Stale);
                force *= share;
            }
            let size = force.norm().min(self.limits.peak).min(self.budget.allowed());
            if let Some(passivity) = &mut self.passivity
                && let Some(damping) =
                    passivity.control(moment.position, Load { size, compliance: moment.compliance }, dt)
            {
                self.counts[Cause::Passivity as usize] += 1;
                force += damping;
            }
        }
        force = self.shorten(force, self.limits.peak, Cause::Magnitude);
        force = self.shorten(force, self.budget.allowed(), Cause::Continuous);
        let change = force - self.last;
        let (jump, most) = (change.norm(), self.limits.slew * dt);
        if jump > most {
            self.count(Cause::Slew);
            force = self.last + most / jump * change;
        }
        self.budget.spend(force, dt);
        if let Some(passivity) = &mut self.passivity {
            passivity.given(force);
        }
        self.last = force;
        force
    }

    fn shorten(&mut self, force: Vec3, most: f64, cause: Cause) -> Vec3 {
        let size = force.norm();
        if size <= most {
            return force;
        }
        self.count(cause);
        // A size that overflowed has no direction left either.
        let scale = if size.is_finite() { most / size } else { 0.0 };
        force * scale
    }

    fn count(&mut self, cause: Cause) {
        self.counts[cause as usize] += 1;
    }

    /// Zero from now on, at once: the hand is let go.
    pub fn release(&mut self) {
        self.last = Vec3::zeros();
        if let Some(passivity) = &mut self.passivity {
            passivity.forget();
        }
    }

    /// How often each cause changed a force.
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
    fn whatever_comes_in_what_goes_out_is_finite_and_within_limits() {
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
    fn a_force_within_limits_passes_untouched_and_a_large_one_keeps_its_direction() {
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
    fn a_silent_simulation_is_at_zero_after_150_ms() {
        let mut safety = safety();
        let still = |age| Moment { position: Vec3::zeros(), age, compliance: 0.0 };
        let mut given = |age| safety.pass_live(Vec3::z(), still(age), 1e-2)[2];
        assert_eq!([0.0, 0.049, 0.1, 0.151, 60.0].map(&mut given), [1.0, 1.0, 0.5, 0.0, 0.0]);
        assert_eq!(count(&safety, Cause::Stale), 3);
    }

    #[test]
    fn the_mean_force_stays_within_the_continuous_rating() {
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
