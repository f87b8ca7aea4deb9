//! What a simulation that is slower than the hand says about a contact: enough to render it until the next step.
//!
//! `F = F0 + Kc (x0 - x)`, with the place x0 that was felt at drifting as the surface under the tool does (the local model of
//! Adachi, Kumano and Ogino 1995, with a stiffness in the place of a plane).

use pliant_solver::{Block, Vec3, matrix3};

/// A contact, as of one sample of the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactModel {
    /// When that sample was taken, ns.
    pub time: u64,
    /// Force on the hand, N.
    pub force: Vec3,
    /// Where the hand was, m.
    pub at: Vec3,
    /// How what holds the hand moves, m/s.
    pub drift: Vec3,
    /// Stiffness: force lost per displacement of the hand, symmetric, N/m.
    pub stiffness: Block,
    /// Out of the surface: the force never pulls against it. `None`: it holds on both sides.
    pub normal: Option<Vec3>,
}

impl ContactModel {
    /// Force on a hand at `x` (m), `after` (s) the sample; it drifts for `drifts` (s) at most, N.
    pub fn force(&self, x: Vec3, after: f64, drifts: f64) -> Vec3 {
        let held = self.at + after.clamp(0.0, drifts) * self.drift;
        let moved = held - x;
        let force = self.force + matrix3(&self.stiffness) * moved;
        match self.normal {
            Some(n) if force.dot(&n) <= 0.0 => Vec3::zeros(),
            _ => force,
        }
    }
}

/// The newest contact, and the one before it for as long as it takes to change over.
#[derive(Clone, Copy, Debug, Default)]
pub struct Blend {
    now: ContactModel,
    before: ContactModel,
    /// When `now` came, ns.
    came: u64,
    /// Period between the last two, smoothed, s.
    period: f64,
}

/// The longest change-over, and the longest drift, s.
const LONGEST: f64 = 0.02;

impl Blend {
    /// Takes another contact at `time` (ns).
    pub fn take(&mut self, model: ContactModel, time: u64) {
        let since = seconds(time.saturating_sub(self.came)).min(LONGEST);
        self.period = if self.period == 0.0 { since } else { 0.9 * self.period + 0.1 * since };
        (self.before, self.now, self.came) = (self.now, model, time);
    }

    /// Force on a hand at `x` (m) at `time` (ns): from what the model before says there to what the newest says, over a period, N.
    pub fn force(&self, x: Vec3, time: u64) -> Vec3 {
        let after = |model: &ContactModel| seconds(time.saturating_sub(model.time));
        let drifts = 2.0 * self.period;
        let new = self.now.force(x, after(&self.now), drifts);
        let share = if self.period > 0.0 { seconds(time.saturating_sub(self.came)) / self.period } else { 1.0 };
        if share >= 1.0 {
            return new;
        }
        let old = self.before.force(x, after(&self.before), drifts);
        old + share * (new - old)
    }

    /// Compliance of the newest coupling along `force` (N): inverse of what it resists with in that direction; 0 without any, m/N.
    pub fn compliance(&self, force: Vec3) -> f64 {
        let resisted = matrix3(&self.now.stiffness) * force;
        let (size, along) = (force.norm_squared(), force.dot(&resisted));
        if along > 0.0 && size > 0.0 { size / along } else { 0.0 }
    }

    /// Time since the sample of the hand that the newest model answers, s.
    pub fn age(&self, time: u64) -> f64 {
        seconds(time.saturating_sub(self.now.time))
    }

    /// Whether it pushes at all.
    pub fn is_contact(&self) -> bool {
        self.now.force != Vec3::zeros()
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn wall(height: f64, time: u64, x: f64) -> ContactModel {
        let mut stiffness = [0.0; 9];
        stiffness[0] = 500.0;
        let force = Vec3::new(500.0 * (height - x).max(0.0), 0.0, 0.0);
        ContactModel {
            time,
            force,
            at: Vec3::new(x, 0.0, 0.0),
            stiffness,
            normal: Some(Vec3::x()),
            ..Default::default()
        }
    }

    #[test]
    fn between_steps_the_hand_feels_the_wall_and_never_its_pull() {
        let model = wall(0.0, 0, -1e-3);
        assert!((model.force(Vec3::new(-2e-3, 0.0, 0.0), 0.0, 0.0)[0] - 1.0).abs() < 1e-12);
        assert_eq!(model.force(Vec3::new(1e-3, 5.0, 0.0), 0.0, 0.0), Vec3::zeros());
    }

    #[test]
    fn a_new_model_comes_in_over_a_period_without_a_jump() {
        let (mut blend, x) = (Blend::default(), Vec3::new(-1e-3, 0.0, 0.0));
        for step in 1..200 {
            blend.take(wall(0.0, step * 4 * MS, -1e-3), step * 4 * MS);
        }
        let at = 200 * 4 * MS;
        let before = blend.force(x, at)[0];
        blend.take(wall(1e-3, at, -1e-3), at);
        let after: Vec<f64> = (0..5).map(|tick| blend.force(x, at + tick * MS)[0]).collect();
        assert!((before - 0.5).abs() < 1e-12 && (after[0] - before).abs() < 1e-12, "{before} {after:?}");
        assert!(
            after.windows(2).all(|w| (w[1] - w[0] - 0.125).abs() < 1e-9) && (after[4] - 1.0).abs() < 1e-9,
            "{after:?}"
        );
        assert!((blend.age(at + 7 * MS) - 7e-3).abs() < 1e-12);
    }

    #[test]
    fn what_moves_with_the_hand_does_not_drag() {
        let mut model = wall(0.0, 0, -1e-3);
        model.drift = Vec3::new(0.1, 0.0, 0.0);
        let moved = model.force(Vec3::new(-1e-3 + 4e-4, 0.0, 0.0), 4e-3, 8e-3);
        assert!((moved[0] - model.force[0]).abs() < 1e-12, "{moved:?}");
    }
}
