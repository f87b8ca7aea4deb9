//! Local contact model: what a slow simulation sends to the faster haptic loop, which renders it until the next step.
//!
//! The force is `F = F0 + Kc (x0 - x)`; the reference position x0 drifts with the surface under the tool (local model of Adachi, Kumano and
//! Ogino 1995, with a stiffness instead of a plane).

use pliant_solver::{Block, Vec3, matrix3};

/// A linear model of a contact about one sample of the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactModel {
    /// Time of that sample, ns.
    pub time: u64,
    /// Force on the hand, N.
    pub force: Vec3,
    /// Position of the hand in that sample, m.
    pub at: Vec3,
    /// Velocity of the contact surface, m/s.
    pub drift: Vec3,
    /// Stiffness: negative derivative of the force by the position of the hand, symmetric, N/m.
    pub stiffness: Block,
    /// Unit outward normal of a unilateral contact, whose force never pulls; `None` for a bilateral one, such as a grip.
    pub normal: Option<Vec3>,
}

impl ContactModel {
    /// Force on a hand at `x` (m) at the time `after` (s) from the sample, N. The reference drifts for at most `drifts` (s).
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

/// The newest contact model, and the previous one until the transition between them is complete.
#[derive(Clone, Copy, Debug, Default)]
pub struct Blend {
    now: ContactModel,
    before: ContactModel,
    /// Arrival time of the newest model, ns.
    came: u64,
    /// Smoothed period between models, s.
    period: f64,
}

/// Largest duration of a transition and of a drift, s.
const MAX_DURATION: f64 = 0.02;

impl Blend {
    /// Adds a model that arrives at `time` (ns).
    pub fn take(&mut self, model: ContactModel, time: u64) {
        let since = seconds(time.saturating_sub(self.came)).min(MAX_DURATION);
        self.period = if self.period == 0.0 { since } else { 0.9 * self.period + 0.1 * since };
        (self.before, self.now, self.came) = (self.now, model, time);
    }

    /// Force on a hand at `x` (m) at `time` (ns), N: over a period it changes linearly from that of the previous model to that of the newest.
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

    /// Compliance of the newest model along `force` (N), m/N: the inverse of its stiffness in that direction; 0 if there is none.
    pub fn compliance(&self, force: Vec3) -> f64 {
        let resisted = matrix3(&self.now.stiffness) * force;
        let (size, along) = (force.norm_squared(), force.dot(&resisted));
        if along > 0.0 && size > 0.0 { size / along } else { 0.0 }
    }

    /// Age, s, at `time` (ns) of the hand sample behind the newest model.
    pub fn age(&self, time: u64) -> f64 {
        seconds(time.saturating_sub(self.now.time))
    }

    /// Whether the newest model has a nonzero force.
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
    fn between_steps_the_wall_pushes_and_never_pulls() {
        let model = wall(0.0, 0, -1e-3);
        assert!((model.force(Vec3::new(-2e-3, 0.0, 0.0), 0.0, 0.0)[0] - 1.0).abs() < 1e-12);
        assert_eq!(model.force(Vec3::new(1e-3, 5.0, 0.0), 0.0, 0.0), Vec3::zeros());
    }

    #[test]
    fn transition_between_models_is_continuous() {
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
    fn a_surface_moving_with_the_hand_does_not_drag() {
        let mut model = wall(0.0, 0, -1e-3);
        model.drift = Vec3::new(0.1, 0.0, 0.0);
        let moved = model.force(Vec3::new(-1e-3 + 4e-4, 0.0, 0.0), 4e-3, 8e-3);
        assert!((moved[0] - model.force[0]).abs() < 1e-12, "{moved:?}");
    }
}
