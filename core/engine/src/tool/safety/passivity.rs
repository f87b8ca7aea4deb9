//! Passivity observer and controller (Hannaford and Ryu 2002).
//!
//! A force F that is held constant while the hand moves by d does the work F . d on it, whatever path the hand takes. The observer sums
//! this work; when the sum shows that the force has generated energy, the controller adds damping, at most what the device can render.
//!
//! Deviations from Hannaford and Ryu 2002:
//! 1. The reference is the energy stored in the coupling, not zero (Ryu, Preusche, Hannaford and Hirzinger 2005): the energy of a compressed
//!    spring would otherwise count as credit and hide an oscillation about the compressed position for minutes.
//! 2. Generated energy that could not be damped decays with a time constant of 0.2 s, because quantisation makes a hand at rest between two
//!    encoder counts appear to receive energy continuously.
//! 3. The energy balance is clamped to the largest energy the coupling can store, so that a long dissipative phase does not pay for a burst.
//! 4. The speed for the damping is measured over the shortest window in which the hand has moved by more than two counts, at most 8 ms
//!    (Janabi-Sharifi, Hayward and Chen 2000): a fixed number of samples is too short for an encoder at 4 kHz, or at 250 Hz so long that the
//!    delayed damping itself drives the hand.

use pliant_solver::Vec3;

/// Load of the virtual coupling.
#[derive(Clone, Copy, Debug, Default)]
pub struct CouplingLoad {
    /// Magnitude of the force, N.
    pub force: f64,
    /// Compliance of the coupling along the force, m/N; 0 if unknown, which sets the reference energy to zero.
    pub compliance: f64,
}

/// Energy balance of one effector.
#[derive(Clone, Debug)]
pub struct Passivity {
    /// Whether the controller damps; otherwise the observer only measures.
    pub controls: bool,
    /// Largest damping, N s/m.
    max_damping: f64,
    /// Position resolution of the device (one count), m.
    resolution: f64,
    /// Bound of the energy balance on both sides, J.
    max_energy: f64,
    /// Energy put in by the hand minus energy returned to it, J.
    energy: f64,
    /// Force applied since the last sample, N.
    force: Vec3,
    /// Ring buffer of the last positions of the hand, m; the newest is at `next - 1`.
    positions: [Vec3; HISTORY],
    next: usize,
    /// Number of valid positions, at most `HISTORY`.
    filled: usize,
}

/// Displacement, in counts, above which a hand counts as moving: one count on each axis can be quantisation, and damping that shakes the hand.
const MOTION_THRESHOLD: f64 = 2.0;
/// Deadband of the coupling's compression, in counts: a compression below it stores no energy, for it may be quantisation.
const COMPRESSION_DEADBAND: f64 = 4.0;
/// Time constant in which generated energy decays, s.
const DECAY_TIME: f64 = 0.2;
/// Longest window over which the speed of the hand is measured, s.
const MAX_SPEED_WINDOW: f64 = 8e-3;
/// Positions kept: the 32 of the longest window at 4 kHz, the fastest haptic rate, and a few more.
const HISTORY: usize = 40;

impl Passivity {
    /// A balance of zero for a device that damps at most `max_damping` (N s/m) and measures positions to `resolution` (m), with a coupling
    /// that stores at most `max_energy` (J).
    pub fn new(max_damping: f64, resolution: f64, max_energy: f64) -> Self {
        Self {
            controls: true,
            max_damping,
            resolution,
            max_energy,
            energy: 0.0,
            force: Vec3::zeros(),
            positions: [Vec3::zeros(); HISTORY],
            next: 0,
            filled: 0,
        }
    }

    /// Energy the hand has put in minus energy returned to it, J; negative if the force has generated energy.
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// Adds a sample of the hand at `position` (m) with the coupling under `load`, `dt` (s) after the last one. Returns the damping force to
    /// add, N; `None` if the force is passive, the controller is off or the hand does not move.
    pub fn control(&mut self, position: Vec3, load: CouplingLoad, dt: f64) -> Option<Vec3> {
        if !position.iter().all(|c| c.is_finite()) {
            return None;
        }
        if self.filled > 0 {
            let work = self.force.dot(&(position - self.position(1)));
            self.energy = (self.energy - work).clamp(-self.max_energy, self.max_energy);
        }
        let motion = self.recent_motion(position, dt);
        self.positions[self.next] = position;
        self.next = (self.next + 1) % HISTORY;
        self.filled = (self.filled + 1).min(HISTORY);
        let generated = self.stored(load) - self.energy;
        if generated <= 0.0 || !self.controls {
            return None;
        }
        self.energy += generated * (dt / DECAY_TIME).min(1.0);
        let (displacement, length, duration) = motion?;
        let speed = length / duration;
        let damping = (generated / (dt * speed * speed)).min(self.max_damping);
        Some(-damping * speed * displacement / length)
    }

    /// Lower bound of the energy stored in the coupling, J: that of its compression less the deadband, because a hand that moves by single
    /// counts puts in less work than a smooth one.
    fn stored(&self, CouplingLoad { force, compliance }: CouplingLoad) -> f64 {
        let compression = (compliance * force - COMPRESSION_DEADBAND * self.resolution).max(0.0);
        if compliance > 0.0 { 0.5 * compression * compression / compliance } else { 0.0 }
    }

    /// Position of the hand this many samples ago, m.
    fn position(&self, ago: usize) -> Vec3 {
        self.positions[(self.next + HISTORY - ago) % HISTORY]
    }

    /// Displacement of the hand to `position` (m), its length (m) and its duration (s), over the shortest window in which it exceeds the
    /// motion threshold; `None` if it does not within the longest window.
    fn recent_motion(&self, position: Vec3, dt: f64) -> Option<(Vec3, f64, f64)> {
        let longest = ((MAX_SPEED_WINDOW / dt) as usize).clamp(1, HISTORY).min(self.filled);
        (1..=longest).find_map(|ago| {
            let displacement = position - self.position(ago);
            let length = displacement.norm();
            let moves = length > MOTION_THRESHOLD * self.resolution && length > 0.0;
            moves.then_some((displacement, length, ago as f64 * dt))
        })
    }

    /// Sets the force (N) that acts on the hand until the next sample.
    pub fn set_applied_force(&mut self, force: Vec3) {
        self.force = force;
    }

    /// Goes on from the energy balance and the motion of another observer of the same hand, with forces of the same scale.
    pub fn resume(&mut self, before: &Self) {
        self.energy = before.energy.clamp(-self.max_energy, self.max_energy);
        (self.force, self.positions) = (before.force, before.positions);
        (self.next, self.filled) = (before.next, before.filled);
    }

    /// Sets the balance to zero and empties the history: the hand was released.
    pub fn reset(&mut self) {
        (self.energy, self.force, self.next, self.filled) = (0.0, Vec3::zeros(), 0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moves a hand sinusoidally against a spring of 100 N/m whose force is delayed by `delay` samples. Returns the work of the force on the
    /// hand and the observer's balance, both in J.
    fn oscillate(delay: usize, controls: bool) -> (f64, f64) {
        let mut passivity = Passivity { controls, ..Passivity::new(5.0, 0.0, 0.05) };
        let x = |k: usize| 1e-3 * (k as f64 * 0.2).sin();
        let (mut work, mut force) = (0.0, 0.0);
        for k in delay..20_000 {
            work += force * (x(k) - x(k - 1));
            let damping =
                passivity.control(Vec3::new(x(k), 0.0, 0.0), CouplingLoad::default(), 1e-3).unwrap_or_default();
            force = -100.0 * x(k - delay) + damping[0];
            passivity.set_applied_force(Vec3::new(force, 0.0, 0.0));
        }
        (work, passivity.energy())
    }

    #[test]
    fn energy_of_a_delayed_spring_is_observed_and_damped() {
        let (work, balance) = oscillate(3, false);
        assert!(work > 0.05 && balance < -0.04, "generated {work} J, observed {balance} J");
        let (work, _) = oscillate(3, true);
        assert!(work < 1e-3, "generated {work} J under control");
    }

    #[test]
    fn a_lossless_spring_is_not_damped() {
        let mut passivity = Passivity::new(5.0, 0.0, 0.05);
        for k in 0..1000_i32 {
            // Compressed by 10 mm and released; the force at the midpoint of each sample makes the work exact.
            let place = |k: i32| 2e-5 * f64::from(k.min(1000 - k));
            assert_eq!(
                passivity.control(Vec3::new(place(k), 0.0, 0.0), CouplingLoad::default(), 1e-3),
                None,
                "{k}: {} J",
                passivity.energy()
            );
            passivity.set_applied_force(Vec3::new(-100.0 * 0.5 * (place(k) + place(k + 1)), 0.0, 0.0));
        }
    }
}
