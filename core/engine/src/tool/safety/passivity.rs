//! Observer and controller of passivity (Hannaford and Ryu 2002), with the energy of the coupling as its reference (Ryu,
//! Preusche, Hannaford and Hirzinger 2005).
//!
//! A force F that is held while the hand moves by d gives it the energy F . d, exactly, whatever the hand does in between. What
//! was taken from the hand and not given back must be at least what the coupling holds now: a spring that holds more than was
//! put in has made it, by being late. Where it is less, the controller damps, at most as hard as the device can render.
//! Without that reference the energy of a spring that is pressed counts as credit, and pays for a swing about the press for
//! minutes.
//!
//! Three deviations: what was made and could not be damped is forgotten within tenths of a second, as a hand at rest on the
//! edge of a count seems to be given a little all the time; credit is bounded by what the coupling can have stored, so that a
//! long calm phase does not pay for a burst (the forgetting of dissipated energy that later authors add); and the speed the
//! damping works on is taken over the shortest time in which the hand has moved by more than two counts, up to 8 ms
//! (Janabi-Sharifi, Hayward and Chen 2000). A fixed number of samples is either too few for an encoder at 4 kHz or, at 250 Hz,
//! so late that the damping itself drives the hand.

use pliant_solver::Vec3;

/// What the coupling bears.
#[derive(Clone, Copy, Debug, Default)]
pub struct Load {
    /// N, size of the force
    pub size: f64,
    /// m/N, how far the coupling gives way along it
    pub compliance: f64,
}

/// The energy account of one effector.
#[derive(Clone, Debug)]
pub struct Passivity {
    /// Whether the controller acts, or the observer only watches.
    pub controls: bool,
    /// Largest damping, N s/m.
    damping: f64,
    /// Resolution, m.
    resolution: f64,
    /// Largest credit, J.
    most: f64,
    /// J, taken from the hand and not given back
    energy: f64,
    /// Force, N.
    force: Vec3,
    /// The last places of the hand, the newest at `next - 1`, m.
    places: [Vec3; PLACES],
    next: usize,
    filled: usize,
}

/// Counts of a device above which a hand has moved: one on each axis may be nothing but the edge of a count, and what is damped
/// for that shakes the hand.
const MOVED: f64 = 2.0;
/// Counts of a device within which it is not told what a coupling holds.
const BLIND: f64 = 4.0;
/// Forgets in which what was made is forgotten by a factor of e, s.
const FORGETS: f64 = 0.2;
/// The longest a speed is taken over, s.
const LONGEST: f64 = 8e-3;
/// Places that are kept: a few more than there are in that time at 4 kHz, the fastest loop.
const PLACES: usize = 40;

impl Passivity {
    /// Of a device that damps at most `damping` (N s/m), reads places to `resolution` (m), and may have stored `most` (J).
    pub fn new(damping: f64, resolution: f64, most: f64) -> Self {
        let places = [Vec3::zeros(); PLACES];
        Self {
            controls: true,
            damping,
            resolution,
            most,
            energy: 0.0,
            force: Vec3::zeros(),
            places,
            next: 0,
            filled: 0,
        }
    }

    /// What the hand has given and not got back; below zero: made by the force, J.
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// N, the damping force to add while the hand is at `position` (m) under `load`, `dt` (s) after the last time; `None` where the
    /// force is passive as it is.
    pub fn control(&mut self, position: Vec3, load: Load, dt: f64) -> Option<Vec3> {
        if !position.iter().all(|c| c.is_finite()) {
            return None;
        }
        if self.filled > 0 {
            let given = self.force.dot(&(position - self.place(1)));
            self.energy = (self.energy - given).clamp(-self.most, self.most);
        }
        let way = self.way(position, dt);
        self.places[self.next] = position;
        self.next = (self.next + 1) % PLACES;
        self.filled = (self.filled + 1).min(PLACES);
        let made = self.stored(load) - self.energy;
        if made <= 0.0 || !self.controls {
            return None;
        }
        self.energy += made * (dt / FORGETS).min(1.0);
        let (way, length, span) = way?;
        let speed = length / span;
        let damping = (made / (dt * speed * speed)).min(self.damping);
        Some(-damping * speed * way / length)
    }

    /// J, what the coupling holds at least: pressed in by some counts less than it seems, as a hand that goes in by single
    /// counts gives it less than a smooth one.
    fn stored(&self, Load { size, compliance }: Load) -> f64 {
        let pressed = (compliance * size - BLIND * self.resolution).max(0.0);
        if compliance > 0.0 { 0.5 * pressed * pressed / compliance } else { 0.0 }
    }

    /// Where the hand was this many samples ago, m.
    fn place(&self, ago: usize) -> Vec3 {
        self.places[(self.next + PLACES - ago) % PLACES]
    }

    /// m, the way to `position` from where the hand was last some counts away, its length, and in which time, s; none
    /// for a hand that rests, as far as the device can tell.
    fn way(&self, position: Vec3, dt: f64) -> Option<(Vec3, f64, f64)> {
        let longest = ((LONGEST / dt) as usize).clamp(1, PLACES).min(self.filled);
        (1..=longest).find_map(|ago| {
            let way = position - self.place(ago);
            let length = way.norm();
            (length > MOVED * self.resolution && length > 0.0).then_some((way, length, ago as f64 * dt))
        })
    }

    /// The force (N) the hand has from now on.
    pub fn given(&mut self, force: Vec3) {
        self.force = force;
    }

    /// The hand is let go: what comes next is another touch.
    pub fn forget(&mut self) {
        (self.energy, self.force, self.next, self.filled) = (0.0, Vec3::zeros(), 0, 0);
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
            let more = passivity.control(Vec3::new(place(k), 0.0, 0.0), Load::default(), 1e-3).unwrap_or_default();
            force = -100.0 * place(k - late) + more[0];
            passivity.given(Vec3::new(force, 0.0, 0.0));
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
            assert_eq!(
                passivity.control(Vec3::new(place(k), 0.0, 0.0), Load::default(), 1e-3),
                None,
                "{k}: {} J",
                passivity.energy()
            );
            passivity.given(Vec3::new(-100.0 * 0.5 * (place(k) + place(k + 1)), 0.0, 0.0));
        }
    }
}
