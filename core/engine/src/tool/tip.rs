//! A fingertip with a mass between a hand and a sheet.
//!
//! Contact constraints on a sheet are exact, so a tip at the position of the hand would transmit every impulse of the solver. Here the hand
//! drives the tip through the virtual coupling (Adams and Hannaford 1999): the hand feels the spring; the spring and the sheet accelerate the
//! tip. Two tips may overlap by the compression of a finger's pulp only, so a pinch gives a coupling force on both hands.

use super::tool::Coupling;
use crate::contact::TipResponse;
use pliant_solver::Vec3;

/// A fingertip with a mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipMass {
    /// Mass of the tip, kg.
    pub mass: f64,
    /// Position of its centre, m.
    pub position: Vec3,
    /// Velocity of its centre, m/s.
    pub velocity: Vec3,
    /// Whether a hand drives it now.
    led: bool,
    /// Velocity without a force of sheets in this step, m/s, and the inertia against one, kg.
    free: Option<(Vec3, f64)>,
    /// Force of sheets at the end of the last step, N, that its velocity follows from already.
    implicit_force: Option<Vec3>,
    /// External force in the last step, N.
    force: Vec3,
    /// Displacement in the last step, m.
    moved: Vec3,
    /// Sums over the last steps of what the external force changed times the displacement against it, J, and of the displacement squared, m^2.
    resisted: [f64; 2],
}

/// Overlap allowed between two tips, as a fraction of their mean radius: the compression of both pulps.
const PULP: f64 = 0.25;
/// Least inertia of the tip over what the stiffness against it comes to in a step: above 1 the response to a constant force dies away.
const CONTRACTION: f64 = 2.0;
/// Share of the sums of [`TipMass::resisted`] that is kept from step to step, so that a tip that has left a stiff sheet does not fall onto it at
/// full speed again.
const MEMORY: f64 = 0.9;

impl TipMass {
    /// A tip of this mass (kg), which starts at rest at the position of the hand.
    pub fn new(mass: f64) -> Self {
        let zero = Vec3::zeros();
        Self {
            mass,
            position: zero,
            velocity: zero,
            led: false,
            free: None,
            implicit_force: None,
            force: zero,
            moved: zero,
            resisted: [0.0; 2],
        }
    }

    /// Moves the tip over `dt` (s) towards a hand at `hand` (m) with the velocity `speed` (m/s), under the external `force` (N): backward Euler
    /// with the coupling's spring and a critical damper between tip and hand, which is not part of [`Self::coupling_force`].
    ///
    /// `force` is that of the last step. Where it grows with the displacement of the tip so fast that a step with a constant force would be
    /// unstable, its change is part of the step too.
    pub fn drive_kinematic(&mut self, hand: Vec3, speed: Vec3, coupling: &Coupling, force: Vec3, dt: f64) {
        if !self.led {
            (self.position, self.velocity, self.led) = (hand, speed, true);
            (self.force, self.moved, self.resisted) = (force, Vec3::zeros(), [0.0; 2]);
            (self.free, self.implicit_force) = (None, None);
            return;
        }
        let (m, k) = (self.mass, coupling.stiffness);
        let c = 2.0 * (m * k).sqrt();
        let inertia = m + dt * c + dt * dt * k;
        // A force that the last step followed from is no force of this one, and tells nothing of the stiffness.
        let applied = self.implicit_force.take();
        // The stiffness against the tip: by the last step, as when it meets a sheet, or by least squares over more of them, as beside a sheet.
        let last = match applied {
            Some(_) => [0.0; 2],
            None => [-(force - self.force).dot(&self.moved), self.moved.norm_squared()],
        };
        let memory = if applied.is_some() { 0.0 } else { MEMORY };
        self.resisted = std::array::from_fn(|i| memory * self.resisted[i] + last[i]);
        let ratio = |[work, squares]: [f64; 2]| if squares > 0.0 { work / squares } else { 0.0 };
        let excess = (CONTRACTION * dt * dt * ratio(last).max(ratio(self.resisted)) - inertia).max(0.0);
        (self.force, self.moved) = (force, self.position);
        let mut free = Vec3::zeros();
        for i in 0..3 {
            // Towards the position of the hand at the end of the step.
            let pull = k * (hand[i] - self.position[i]) + c * speed[i];
            free[i] = (m * self.velocity[i] + dt * pull) / inertia;
            let all = pull + force[i] - applied.map_or(0.0, |applied| applied[i]);
            self.velocity[i] = (m * self.velocity[i] + dt * all) / (inertia + excess);
            self.position[i] += dt * self.velocity[i];
        }
        self.free = Some((free, inertia));
        self.moved = self.position - self.moved;
    }

    /// How its velocity depends on the force of a sheet in this step of `dt` (s), beside the force `others` (N) of other sheets.
    pub fn response(&self, others: Vec3, dt: f64) -> Option<TipResponse> {
        self.free.map(|(free, inertia)| TipResponse { free: free + dt / inertia * others, inertia, dt })
    }

    /// Changes the velocity of this step of `dt` (s) by `change` (m/s), to that which follows from the `force` (N) of a sheet.
    pub fn apply_implicit_force(&mut self, change: Vec3, force: Vec3, dt: f64) {
        self.velocity += change;
        self.position += dt * change;
        self.moved += dt * change;
        self.implicit_force = Some(force);
    }

    /// Puts the tip at a position (m), at rest; from there it follows the hand.
    pub fn begin_at(&mut self, position: Vec3) {
        *self = Self { position, led: true, ..Self::new(self.mass) };
    }

    /// Marks the hand as absent; the tip starts again at rest where a hand returns.
    pub fn leave(&mut self) {
        self.led = false;
    }

    /// Force on a hand at `hand` (m), N.
    pub fn coupling_force(&self, hand: Vec3, coupling: &Coupling) -> Vec3 {
        if self.led { coupling.stiffness * (self.position - hand) } else { Vec3::zeros() }
    }
}

/// Separates two round tips with radii `ra` and `rb` (m) that overlap by more than the compression of their pulps.
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
    fn a_tip_follows_without_lag_and_rests_in_equilibrium() {
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
    fn a_wall_of_any_stiffness_does_not_throw_a_tip() {
        for stiffness in [1e1, 1e3, 1e5, 1e7, 1e9] {
            for mass in [1e-3, 1e-2] {
                for dt in [1e-4, 1e-3, 3e-2] {
                    let (mut tip, depth) = (TipMass::new(mass), 5e-3);
                    let (mut deepest, mut highest) = (0.0_f64, 0.0_f64);
                    for step in 0..4000 {
                        // Above the wall at 0, then as deep in it as a hand would be.
                        let hand = Vec3::new(0.0, 0.0, if step < 2 { 1e-3 } else { -depth });
                        let wall = Vec3::new(0.0, 0.0, stiffness * (-tip.position[2]).max(0.0));
                        tip.drive_kinematic(hand, Vec3::zeros(), &COUPLING, wall, dt);
                        deepest = deepest.min(tip.position[2]);
                        highest = highest.max(tip.position[2]);
                    }
                    let what = format!("{stiffness} N/m, {mass} kg, {dt} s");
                    assert!(deepest >= -1.01 * depth && highest < 2.0 * depth, "{what}: {deepest} to {highest}");
                    let rest = -COUPLING.stiffness * depth / (COUPLING.stiffness + stiffness);
                    assert!((tip.position[2] - rest).abs() < 0.05 * depth, "{what}: {} for {rest}", tip.position[2]);
                }
            }
        }
    }

    #[test]
    fn a_pinch_gives_equal_and_opposite_forces() {
        let (mut a, mut b) = (TipMass::new(0.01), TipMass::new(0.01));
        let (left, right) = (Vec3::new(-0.005, 0.0, 0.0), Vec3::new(0.005, 0.0, 0.0));
        a.drive_kinematic(Vec3::new(-0.02, 0.0, 0.0), Vec3::zeros(), &COUPLING, Vec3::zeros(), 1e-3);
        b.drive_kinematic(Vec3::new(0.02, 0.0, 0.0), Vec3::zeros(), &COUPLING, Vec3::zeros(), 1e-3);
        for _ in 0..500 {
            a.drive_kinematic(left, Vec3::zeros(), &COUPLING, Vec3::zeros(), 1e-3);
            b.drive_kinematic(right, Vec3::zeros(), &COUPLING, Vec3::zeros(), 1e-3);
            separate(&mut a, 0.01, &mut b, 0.01);
        }
        // The hands are 10 mm apart, the tips 17.5 mm, so each spring is stretched by 3.75 mm.
        let (fa, fb) = (a.coupling_force(left, &COUPLING)[0], b.coupling_force(right, &COUPLING)[0]);
        assert!((fa + 0.75).abs() < 1e-9 && (fb - 0.75).abs() < 1e-9, "{fa} {fb}");
    }
}
