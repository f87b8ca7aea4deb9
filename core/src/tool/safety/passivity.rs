//! Observer and controller of passivity (Hannaford and Ryu 2002).
//!
//! A force F that is held while the hand moves by d gives it the energy F . d, exactly, whatever the hand does in between. What
//! has been given may not exceed what was taken; where it does, the controller damps, at most as hard as the device can
//! render. Two deviations: credit is bounded by what the coupling can have stored, so that a long calm phase does not pay for a
//! burst (the forgetting of dissipated energy that later authors add), and the speed the damping works on is that over eight
//! samples, as one sample of an encoder says too little of it.

use crate::step::{V3, axpy, dot};

/// The energy account of one effector.
#[derive(Clone, Debug)]
pub struct Passivity {
    /// Whether the controller acts, or the observer only watches.
    pub controls: bool,
    /// N s/m, the most it damps
    damping: f64,
    /// m
    resolution: f64,
    /// J, the most credit
    most: f64,
    /// J, taken from the hand and not given back
    energy: f64,
    /// N
    force: V3,
    /// m, the last places of the hand, the newest at `next - 1`
    places: [V3; WINDOW],
    next: usize,
    filled: usize,
}

/// Samples a speed is taken over.
const WINDOW: usize = 8;

impl Passivity {
    /// Of a device that damps at most `damping` (N s/m), reads places to `resolution` (m), and may have stored `most` (J).
    pub fn new(damping: f64, resolution: f64, most: f64) -> Self {
        let places = [[0.0; 3]; WINDOW];
        Self { controls: true, damping, resolution, most, energy: 0.0, force: [0.0; 3], places, next: 0, filled: 0 }
    }

    /// J, what the hand has given and not got back; below zero: made by the force.
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// N, what must be added to a force while the hand is at `position` (m), `dt` (s) after the last time.
    pub fn control(&mut self, position: V3, dt: f64) -> Option<V3> {
        if !position.iter().all(|c| c.is_finite()) {
            return None;
        }
        let newest = self.places[(self.next + WINDOW - 1) % WINDOW];
        if self.filled > 0 {
            let given = dot(self.force, axpy(position, -1.0, newest));
            self.energy = (self.energy - given).clamp(-self.most, self.most);
        }
        let (oldest, spans) = match self.filled {
            WINDOW => (self.places[self.next], WINDOW),
            filled => (self.places[0], filled),
        };
        self.places[self.next] = position;
        self.next = (self.next + 1) % WINDOW;
        self.filled = (self.filled + 1).min(WINDOW);
        if self.energy >= 0.0 || spans == 0 || !self.controls {
            return None;
        }
        let way = axpy(position, -1.0, oldest);
        let length = dot(way, way).sqrt();
        if length <= self.resolution || length == 0.0 {
            return None; // a hand that rests, as far as the device can tell
        }
        let speed = length / (spans as f64 * dt);
        let damping = (-self.energy / (dt * speed * speed)).min(self.damping);
        Some(way.map(|c| -damping * speed * c / length))
    }

    /// The force (N) the hand has from now on.
    pub fn given(&mut self, force: V3) {
        self.force = force;
    }

    /// The hand is let go: what comes next is another touch.
    pub fn forget(&mut self) {
        (self.energy, self.force, self.next, self.filled) = (0.0, [0.0; 3], 0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// J, what the force has given in the end, and what was seen: a hand goes to and fro in a spring of 100 N/m whose force is
    /// `late` samples old.
    fn made(late: usize, controls: bool) -> (f64, f64) {
        let mut passivity = Passivity { controls, ..Passivity::new(5.0, 0.0, 0.05) };
        let place = |k: usize| 1e-3 * (k as f64 * 0.2).sin();
        let (mut made, mut force) = (0.0, 0.0);
        for k in late..20_000 {
            made += force * (place(k) - place(k - 1));
            let more = passivity.control([place(k), 0.0, 0.0], 1e-3).unwrap_or_default();
            force = -100.0 * place(k - late) + more[0];
            passivity.given([force, 0.0, 0.0]);
        }
        (made, passivity.energy())
    }

    #[test]
    fn what_a_late_spring_makes_is_seen_and_damped_away() {
        let (wild, seen) = made(3, false);
        assert!(wild > 0.05 && seen < -0.04, "made {wild} J, seen {seen} J");
        let (tame, _) = made(3, true);
        assert!(tame < 1e-3, "made {tame} J under control");
    }

    #[test]
    fn a_spring_that_gives_back_what_it_took_is_left_alone() {
        let mut passivity = Passivity::new(5.0, 0.0, 0.05);
        for k in 0..1000_i32 {
            // Pressed in by 10 mm and out again; the force of the place in the middle of a sample makes it exact.
            let place = |k: i32| 2e-5 * f64::from(k.min(1000 - k));
            assert_eq!(passivity.control([place(k), 0.0, 0.0], 1e-3), None, "{k}: {} J", passivity.energy());
            passivity.given([-100.0 * 0.5 * (place(k) + place(k + 1)), 0.0, 0.0]);
        }
    }
}
