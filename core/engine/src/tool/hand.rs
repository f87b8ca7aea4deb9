//! Where a hand is: samples of a device, brought into the scene and made safe.
//!
//! A sample that is not valid or not finite is dropped and the last good one stands for 50 ms, then the hand is let go. A
//! sample that is further off than a hand can move is followed at the speed limit.

use nalgebra::{Quaternion, UnitQuaternion};
use pliant_plugin_api::abi::{POSE_VALID, Pose};
use pliant_solver::Vec3;

/// A device's place in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Where the device's origin is, m.
    pub origin: Vec3,
    /// Turns device axes into scene axes.
    pub rotation: UnitQuaternion<f64>,
    /// Scene metres for a metre of the hand.
    pub scale: f64,
}

impl Default for Frame {
    fn default() -> Self {
        Self { origin: Vec3::zeros(), rotation: UnitQuaternion::identity(), scale: 1.0 }
    }
}

impl Frame {
    /// A place of the device in the scene, m.
    pub fn to_scene(&self, place: Vec3) -> Vec3 {
        self.rotation * (self.scale * place) + self.origin
    }

    /// A place of the scene in device axes, m.
    pub fn to_hand(&self, place: Vec3) -> Vec3 {
        self.rotation.inverse() * (place - self.origin) / self.scale
    }

    /// Axes of the hand in the scene, from a unit quaternion (x, y, z, w) of the device; its own where that is none.
    pub fn turned(&self, [x, y, z, w]: [f64; 4]) -> UnitQuaternion<f64> {
        match UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6) {
            Some(turn) => self.rotation * turn,
            None => self.rotation,
        }
    }

    /// A direction of the scene in device axes: forces go this way, unscaled.
    pub fn to_device(&self, vector: Vec3) -> Vec3 {
        self.rotation.inverse() * vector
    }
}

/// A hand as the scene sees it.
#[derive(Clone, Debug)]
pub struct Hand {
    /// Position, m.
    pub position: Vec3,
    /// Turns axes of the hand into scene axes.
    pub rotation: UnitQuaternion<f64>,
    /// Bit i is button i.
    pub buttons: u32,
    /// Whether there is a hand at all.
    pub present: bool,
    /// Largest speed at which it is followed, m/s.
    pub fastest: f64,
    last_good: f64,
    /// Samples that were dropped, and samples that were followed at the limit.
    pub dropped: u64,
    /// See `dropped`.
    pub slowed: u64,
}

/// How long the last good sample stands, s.
const PATIENCE: f64 = 0.05;

impl Hand {
    /// Not there yet.
    pub fn new(fastest: f64) -> Self {
        let (position, last_good) = (Vec3::zeros(), f64::NEG_INFINITY);
        let rotation = UnitQuaternion::identity();
        Self { position, rotation, buttons: 0, present: false, fastest, last_good, dropped: 0, slowed: 0 }
    }

    /// Whether a valid sample has come so far.
    pub fn was_seen(&self) -> bool {
        self.last_good > f64::NEG_INFINITY
    }

    /// Is gone, and presses no button: there is no sample to take.
    pub fn leave(&mut self) {
        self.present = false;
        self.buttons = 0;
    }

    /// Takes a sample at `time`, `dt` (s) after the last.
    pub fn sample(&mut self, pose: &Pose, frame: &Frame, time: f64, dt: f64) {
        let place = frame.to_scene(pose.position.into());
        let good = pose.flags & POSE_VALID != 0 && place.iter().all(|c| c.is_finite());
        if !good {
            self.dropped += 1;
            self.present &= time - self.last_good <= PATIENCE;
            return;
        }
        self.buttons = pose.buttons;
        if pose.orientation.iter().all(|c| c.is_finite()) {
            self.rotation = frame.turned(pose.orientation);
        }
        self.last_good = time;
        if !self.present {
            self.present = true;
            self.position = place;
            return;
        }
        let move_ = place - self.position;
        let (length, most) = (move_.norm(), self.fastest * dt);
        // A comparison with a length that overflowed still takes the second branch, and stays put.
        if length <= most {
            self.position = place;
        } else {
            self.slowed += 1;
            let share = if length.is_finite() { most / length } else { 0.0 };
            self.position += share * move_;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(x: f64) -> Pose {
        Pose { flags: POSE_VALID, position: [x, 0.0, 0.0], ..Pose::default() }
    }

    #[test]
    fn jumps_are_followed_at_the_limit_and_nonsense_is_dropped() {
        let mut hand = Hand::new(2.0);
        let frame = Frame::default();
        hand.sample(&pose(0.0), &frame, 0.0, 1e-3);
        hand.sample(&pose(0.1), &frame, 1e-3, 1e-3);
        assert!((hand.position[0] - 2e-3).abs() < 1e-15 && hand.slowed == 1);
        for wild in [1e6, 1e300, f64::MAX] {
            let before = hand.position[0];
            hand.sample(&pose(wild), &frame, 2e-3, 1e-3);
            assert!(hand.position[0] - before <= 2e-3 + 1e-12);
        }
        hand.sample(&pose(f64::NAN), &frame, 3e-3, 1e-3);
        assert!(hand.present && hand.dropped == 1 && hand.position[0].is_finite());
        hand.sample(&pose(f64::NAN), &frame, 0.06, 1e-3);
        assert!(!hand.present, "let go after 50 ms without a good sample");
    }

    #[test]
    fn frames_turn_scale_and_move() {
        let rotation = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), std::f64::consts::FRAC_PI_2);
        let frame = Frame { origin: Vec3::x(), rotation, scale: 2.0 };
        let at = frame.to_scene(Vec3::x());
        assert!((at[0] - 1.0).abs() < 1e-15 && (at[1] - 2.0).abs() < 1e-15);
        assert!((frame.to_device(Vec3::new(0.0, 3.0, 0.0))[0] - 3.0).abs() < 1e-15);
        assert!((frame.to_hand(at) - Vec3::x()).norm() < 1e-15);
    }
}
