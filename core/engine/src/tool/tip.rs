//! A fingertip with a mass between a hand and a sheet.
//!
//! A sheet holds its vertices on a tip exactly, so a tip that went where the hand goes would feel every impulse of the solver.
//! Here the hand drives the tip through the spring of its coupling, as Adams and Hannaford (1999) propose: the hand feels the
//! spring, the spring and the sheet move the tip. Two tips that meet keep each other out except for the give of a finger's pulp, so a pinch is
//! coupling_force on both.

use super::tool::Coupling;
use pliant_solver::Vec3;

/// The tip of a tool that touches sheets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipMass {
    /// Mass, kg.
    pub mass: f64,
    /// Position, m.
    pub position: Vec3,
    /// Velocity, m/s.
    pub velocity: Vec3,
    /// Whether a hand drives it.
    led: bool,
}

/// Share of the mean radius of two tips that their pulps give way together.
const PULP: f64 = 0.25;

impl TipMass {
    /// At rest wherever a hand first drives it.
    pub fn new(mass: f64) -> Self {
        Self { mass, position: Vec3::zeros(), velocity: Vec3::zeros(), led: false }
    }

    /// Drives it towards a hand that moved to `hand` (m) at `speed` (m/s), against `force` (N), over `dt` (s): backward Euler for the spring
    /// and a critical damper, which is between tip and hand and not coupling_force.
    pub fn drive_kinematic(&mut self, hand: Vec3, speed: Vec3, coupling: &Coupling, force: Vec3, dt: f64) {
        if !self.led {
            (self.position, self.velocity, self.led) = (hand, speed, true);
            return;
        }
        let (m, k) = (self.mass, coupling.stiffness);
        let c = 2.0 * (m * k).sqrt();
        for i in 0..3 {
            // Towards where the hand is at the end of the step.
            let pull = k * (hand[i] - self.position[i]) + c * speed[i] + force[i];
            self.velocity[i] = (m * self.velocity[i] + dt * pull) / (m + dt * c + dt * dt * k);
            self.position[i] += dt * self.velocity[i];
        }
    }

    /// The hand is gone; the tip starts anew where it comes back.
    pub fn leave(&mut self) {
        self.led = false;
    }

    /// Force on a hand at `hand` (m), N.
    pub fn coupling_force(&self, hand: Vec3, coupling: &Coupling) -> Vec3 {
        if self.led { coupling.stiffness * (self.position - hand) } else { Vec3::zeros() }
    }
}

/// Separates two round tips with radii `ra` and `rb` (m) that overlap by more than their pulps give way.
pub fn separate(a: &mut TipMass, ra: f64, b: &mut TipMass, rb: f64) {
    let between = b.position - a.position;
    let distance = between.norm();
    let least = (ra + rb) - PULP * 0.5 * (ra + rb);
    if !a.led || !b.led || distance >= least || distance < 1e-9 {
        return;
    }
    let n = between / distance;
    let share = a.mass / (a.mass + b.mass);
    let out = least - distance;
    a.position -= out * (1.0 - share) * n;
    b.position += out * share * n;
    let closing = (a.velocity - b.velocity).dot(&n);
    if closing > 0.0 {
        a.velocity -= closing * (1.0 - share) * n;
        b.velocity += closing * share * n;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUPLING: Coupling = Coupling { stiffness: 200.0, damping: 0.0, max_force: 3.3 };

    #[test]
    fn it_follows_a_steady_hand_without_lag_and_rests_where_spring_and_load_balance() {
        let mut tip = TipMass::new(0.01);
        let mut hand = Vec3::zeros();
        for _ in 0..300 {
            hand[0] += 1e-4;
            tip.drive_kinematic(hand, Vec3::new(0.1, 0.0, 0.0), &COUPLING, Vec3::zeros(), 1e-3);
        }
        assert!((tip.position[0] - hand[0]).abs() < 1e-9, "{} {}", tip.position[0], hand[0]);
        for _ in 0..300 {
            tip.drive_kinematic(hand, Vec3::zeros(), &COUPLING, Vec3::new(-1.0, 0.0, 0.0), 1e-3);
        }
        assert!((tip.coupling_force(hand, &COUPLING)[0] + 1.0).abs() < 1e-6);
    }

    #[test]
    fn two_hands_that_squeeze_feel_the_same_force_against_each_other() {
        let (mut a, mut b) = (TipMass::new(0.01), TipMass::new(0.01));
        let (left, right) = (Vec3::new(-0.005, 0.0, 0.0), Vec3::new(0.005, 0.0, 0.0));
        a.drive_kinematic(Vec3::new(-0.02, 0.0, 0.0), Vec3::zeros(), &COUPLING, Vec3::zeros(), 1e-3);
        b.drive_kinematic(Vec3::new(0.02, 0.0, 0.0), Vec3::zeros(), &COUPLING, Vec3::zeros(), 1e-3);
        for _ in 0..500 {
            a.drive_kinematic(left, Vec3::zeros(), &COUPLING, Vec3::zeros(), 1e-3);
            b.drive_kinematic(right, Vec3::zeros(), &COUPLING, Vec3::zeros(), 1e-3);
            separate(&mut a, 0.01, &mut b, 0.01);
        }
        // 10 mm apart, kept 17.5 mm apart: each spring is 3.75 mm long.
        let (fa, fb) = (a.coupling_force(left, &COUPLING)[0], b.coupling_force(right, &COUPLING)[0]);
        assert!((fa + 0.75).abs() < 1e-9 && (fb - 0.75).abs() < 1e-9, "{fa} {fb}");
    }
}
