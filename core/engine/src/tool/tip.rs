//! A fingertip with a mass between a hand and a sheet.
//!
//! A sheet holds its vertices on a tip exactly, so a tip that went where the hand goes would feel every impulse of the solver.
//! Here the hand leads the tip through the spring of its coupling, as Adams and Hannaford (1999) propose: the hand feels the
//! spring, the spring and the sheet move the tip. Two tips that meet keep each other out but for what the pulp of a finger
//! gives way, so a pinch is felt on both.

use super::haptic::Coupling;
use pliant_solver::{V3, axpy, dot};

/// The tip of a tool that touches sheets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipMass {
    /// kg
    pub mass: f64,
    /// m
    pub position: V3,
    /// m/s
    pub velocity: V3,
    /// Whether it has been led before.
    led: bool,
}

/// Share of the mean radius of two tips that their pulps give way together.
const PULP: f64 = 0.25;

impl TipMass {
    /// At rest wherever it is first led.
    pub fn new(mass: f64) -> Self {
        Self { mass, position: [0.0; 3], velocity: [0.0; 3], led: false }
    }

    /// Leads it towards a hand that moved to `hand` at `speed` (m/s), against `force` (N), over `dt` (s): backward Euler for
    /// the spring and a damper that is critical; the damper is between tip and hand and not felt.
    pub fn lead(&mut self, (hand, speed): (V3, V3), coupling: &Coupling, force: V3, dt: f64) {
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

    /// N, on a hand at `hand`
    pub fn felt(&self, hand: V3, coupling: &Coupling) -> V3 {
        if self.led { axpy(self.position, -1.0, hand).map(|c| coupling.stiffness * c) } else { [0.0; 3] }
    }
}

/// Parts two tips with these radii (m) that are in each other by more than their pulps give way.
pub fn part(a: (&mut TipMass, f64), b: (&mut TipMass, f64)) {
    let ((a, ra), (b, rb)) = (a, b);
    let between = axpy(b.position, -1.0, a.position);
    let distance = dot(between, between).sqrt();
    let least = (ra + rb) - PULP * 0.5 * (ra + rb);
    if !a.led || !b.led || distance >= least || distance < 1e-9 {
        return;
    }
    let n = between.map(|c| c / distance);
    let share = a.mass / (a.mass + b.mass);
    let out = least - distance;
    a.position = axpy(a.position, -out * (1.0 - share), n);
    b.position = axpy(b.position, out * share, n);
    let closing = dot(axpy(a.velocity, -1.0, b.velocity), n);
    if closing > 0.0 {
        a.velocity = axpy(a.velocity, -closing * (1.0 - share), n);
        b.velocity = axpy(b.velocity, closing * share, n);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUPLING: Coupling = Coupling { stiffness: 200.0, damping: 0.0, most: 3.3 };

    #[test]
    fn it_follows_a_steady_hand_without_lag_and_rests_where_spring_and_load_balance() {
        let mut tip = TipMass::new(0.01);
        let mut hand = [0.0; 3];
        for _ in 0..300 {
            hand[0] += 1e-4;
            tip.lead((hand, [0.1, 0.0, 0.0]), &COUPLING, [0.0; 3], 1e-3);
        }
        assert!((tip.position[0] - hand[0]).abs() < 1e-9, "{} {}", tip.position[0], hand[0]);
        for _ in 0..300 {
            tip.lead((hand, [0.0; 3]), &COUPLING, [-1.0, 0.0, 0.0], 1e-3);
        }
        assert!((tip.felt(hand, &COUPLING)[0] + 1.0).abs() < 1e-6);
    }

    #[test]
    fn two_hands_that_squeeze_feel_the_same_force_against_each_other() {
        let (mut a, mut b) = (TipMass::new(0.01), TipMass::new(0.01));
        let (left, right) = ([-0.005, 0.0, 0.0], [0.005, 0.0, 0.0]);
        a.lead(([-0.02, 0.0, 0.0], [0.0; 3]), &COUPLING, [0.0; 3], 1e-3);
        b.lead(([0.02, 0.0, 0.0], [0.0; 3]), &COUPLING, [0.0; 3], 1e-3);
        for _ in 0..500 {
            a.lead((left, [0.0; 3]), &COUPLING, [0.0; 3], 1e-3);
            b.lead((right, [0.0; 3]), &COUPLING, [0.0; 3], 1e-3);
            part((&mut a, 0.01), (&mut b, 0.01));
        }
        // 10 mm apart, kept 17.5 mm apart: each spring is 3.75 mm long.
        let (fa, fb) = (a.felt(left, &COUPLING)[0], b.felt(right, &COUPLING)[0]);
        assert!((fa + 0.75).abs() < 1e-9 && (fb - 0.75).abs() < 1e-9, "{fa} {fb}");
    }
}
