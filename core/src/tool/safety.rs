//! The last thing a force passes before it reaches a hand, whatever the plugins before it did.
//!
//! In order: not finite becomes zero, magnitude is cut with its direction kept, then its change per time. Each cause has a
//! counter.

use crate::step::{V3, axpy, dot};

/// What a device may be given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceLimits {
    /// N
    pub peak: f64,
    /// N/s
    pub slew: f64,
}

/// Why a force was changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// It held a value that is not finite.
    NotFinite,
    /// It was larger than the device's peak.
    Magnitude,
    /// It changed faster than allowed.
    Slew,
}

impl Cause {
    /// All of them, in order of their counters.
    pub const ALL: [Self; 3] = [Self::NotFinite, Self::Magnitude, Self::Slew];

    /// In reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "force not finite",
            Self::Magnitude => "force over the device's peak",
            Self::Slew => "force changed too fast",
        }
    }
}

/// The force last given to one effector, and what was changed on the way.
#[derive(Clone, Debug)]
pub struct ForceSafety {
    limits: ForceLimits,
    last: V3,
    counts: [u64; 3],
}

impl ForceSafety {
    /// At zero.
    pub fn new(limits: ForceLimits) -> Self {
        Self { limits, last: [0.0; 3], counts: [0; 3] }
    }

    /// The force to give, N, `dt` (s) after the last.
    pub fn pass(&mut self, wanted: V3, dt: f64) -> V3 {
        let mut force = wanted;
        if !wanted.iter().all(|f| f.is_finite()) {
            self.counts[Cause::NotFinite as usize] += 1;
            force = [0.0; 3];
        }
        let size = dot(force, force).sqrt();
        if size > self.limits.peak {
            self.counts[Cause::Magnitude as usize] += 1;
            // A size that overflowed has no direction left either.
            let scale = if size.is_finite() { self.limits.peak / size } else { 0.0 };
            force = force.map(|f| f * scale);
        }
        let change = axpy(force, -1.0, self.last);
        let (jump, most) = (dot(change, change).sqrt(), self.limits.slew * dt);
        if jump > most {
            self.counts[Cause::Slew as usize] += 1;
            force = axpy(self.last, most / jump, change);
        }
        self.last = force;
        force
    }

    /// Zero from now on, at once: the hand is let go.
    pub fn release(&mut self) {
        self.last = [0.0; 3];
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
        ForceSafety::new(ForceLimits { peak: 3.3, slew: 500.0 })
    }

    fn count(safety: &ForceSafety, cause: Cause) -> u64 {
        safety.counts().find(|(c, _)| *c == cause).unwrap().1
    }

    #[test]
    fn whatever_comes_in_what_goes_out_is_finite_and_within_limits() {
        let mut safety = safety();
        let mut last = [0.0; 3];
        for wanted in [
            [f64::NAN, 0.0, 0.0],
            [1e9, -1e9, 0.0],
            [f64::INFINITY, 1.0, 1.0],
            [f64::MAX, f64::MAX, 0.0],
            [0.1, 0.2, 0.3],
            [-3.0, 0.0, 0.0],
        ] {
            let out = safety.pass(wanted, 1e-3);
            let (size, change) = (dot(out, out).sqrt(), axpy(out, -1.0, last));
            assert!(size <= 3.3 + 1e-12 && dot(change, change).sqrt() <= 0.5 + 1e-12, "{wanted:?} {out:?}");
            last = out;
        }
        assert!(count(&safety, Cause::NotFinite) == 2 && count(&safety, Cause::Magnitude) == 2);
    }

    #[test]
    fn a_force_within_limits_passes_untouched_and_a_large_one_keeps_its_direction() {
        let mut safety = safety();
        assert_eq!(safety.pass([0.1, -0.2, 0.3], 1e-3), [0.1, -0.2, 0.3]);
        let mut out = [0.0; 3];
        for _ in 0..20 {
            out = safety.pass([300.0, 400.0, 0.0], 1e-3);
        }
        assert!((out[0] - 1.98).abs() < 1e-12 && (out[1] - 2.64).abs() < 1e-12);
        assert!(count(&safety, Cause::Slew) > 0);
    }
}
