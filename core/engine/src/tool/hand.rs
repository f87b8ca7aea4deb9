//! Samples of a device's hand, transformed to the scene and checked.
//!
//! An invalid or non-finite sample is dropped; the last valid one holds for 50 ms after it was measured, after which the hand counts as absent. A sample that is farther
//! away than a hand can move is followed at the speed limit.

use nalgebra::{Quaternion, UnitQuaternion};
use pliant_plugin_api::abi::{POSE_VALID, Pose};
use pliant_solver::Vec3;

/// Coordinate frame of a device in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Origin of the device in the scene, m.
    pub origin: Vec3,
    /// Rotation from axes of the device to those of the scene.
    pub rotation: UnitQuaternion<f64>,
    /// Displacement in the scene per displacement of the hand, 1.
    pub scale: f64,
}

impl Default for Frame {
    fn default() -> Self {
        Self { origin: Vec3::zeros(), rotation: UnitQuaternion::identity(), scale: 1.0 }
    }
}

impl Frame {
    /// Transforms a point from the device to the scene, m.
    pub fn to_scene(&self, place: Vec3) -> Vec3 {
        self.rotation * (self.scale * place) + self.origin
    }

    /// Transforms a point from the scene to the device, m.
    pub fn to_hand(&self, place: Vec3) -> Vec3 {
        self.rotation.inverse() * (place - self.origin) / self.scale
    }

    /// Rotation from axes of the hand to those of the scene, from the device's unit quaternion (x, y, z, w); an invalid quaternion counts as the
    /// identity.
    pub fn rotation_in_scene(&self, [x, y, z, w]: [f64; 4]) -> UnitQuaternion<f64> {
        match UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6) {
            Some(turn) => self.rotation * turn,
            None => self.rotation,
        }
    }

    /// Rotates a vector, such as a force, from the scene to the device without scaling.
    pub fn to_device(&self, vector: Vec3) -> Vec3 {
        self.rotation.inverse() * vector
    }
}

/// Where a hand was in the step before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviousPose {
    /// Position of the hand, m.
    pub position: Vec3,
    /// Rotation from axes of the hand to those of the scene.
    pub rotation: UnitQuaternion<f64>,
}

/// State of a hand in the scene.
#[derive(Clone, Debug)]
pub struct Hand {
    /// Position of the hand, m.
    pub position: Vec3,
    /// Rotation from axes of the hand to those of the scene.
    pub rotation: UnitQuaternion<f64>,
    /// Pressed buttons: bit i is button i.
    pub buttons: u32,
    /// Whether a hand is present.
    pub present: bool,
    /// Pose before the last sample; `None` if the hand was absent then.
    pub before: Option<PreviousPose>,
    /// Speed limit, m/s.
    pub fastest: f64,
    last_good: f64,
    /// Number of samples that were dropped.
    pub dropped: u64,
    /// Number of samples that were followed at the speed limit.
    pub slowed: u64,
}

/// Time for which the last valid sample holds, s.
const HOLD_TIME: f64 = 0.05;

impl Hand {
    /// An absent hand with this speed limit (m/s).
    pub fn new(fastest: f64) -> Self {
        let (position, last_good) = (Vec3::zeros(), f64::NEG_INFINITY);
        let rotation = UnitQuaternion::identity();
        Self { position, rotation, buttons: 0, present: false, before: None, fastest, last_good, dropped: 0, slowed: 0 }
    }

    /// Whether there has been a valid sample.
    pub fn was_seen(&self) -> bool {
        self.last_good > f64::NEG_INFINITY
    }

    /// Marks the hand as absent, with no buttons pressed.
    pub fn leave(&mut self) {
        self.present = false;
        self.buttons = 0;
        self.before = None;
    }

    /// Updates the hand from a sample that is measured at `time` (s), `dt` (s) after the last one.
    pub fn sample(&mut self, pose: &Pose, frame: &Frame, time: f64, dt: f64) {
        self.sample_of_age(pose, frame, 0.0, time, dt);
    }

    /// Updates the hand at `time` (s), `dt` (s) after the last sample, from a sample of this `age` (s). An older sample holds for less time.
    pub fn sample_of_age(&mut self, pose: &Pose, frame: &Frame, age: f64, time: f64, dt: f64) {
        let place = frame.to_scene(pose.position.into());
        self.before = self.present.then_some(PreviousPose { position: self.position, rotation: self.rotation });
        let good = pose.flags & POSE_VALID != 0 && place.iter().all(|c| c.is_finite());
        if !good {
            self.dropped += 1;
            self.present &= time - self.last_good <= HOLD_TIME;
            return;
        }
        self.buttons = pose.buttons;
        if pose.orientation.iter().all(|c| c.is_finite()) {
            self.rotation = frame.rotation_in_scene(pose.orientation);
        }
        self.last_good = time - age;
        if !self.present {
            self.present = true;
            self.position = place;
            return;
        }
        let move_ = place - self.position;
        let (length, most) = (move_.norm(), self.fastest * dt);
        // A length that overflowed takes the second branch too, with a displacement of zero.
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
    fn jumps_are_limited_and_invalid_samples_are_dropped() {
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
    fn a_sample_holds_for_50_ms_after_it_was_measured() {
        for (age, ticks) in [(0.0, 51), (0.03, 21), (0.0495, 1), (0.2, 1)] {
            let mut hand = Hand::new(2.0);
            hand.sample_of_age(&pose(0.0), &Frame::default(), age, 1.0, 1e-3);
            let let_go = (1..100).find(|tick| {
                // In the middle of a tick, as rounding decides at its ends.
                let time = 1.0 + 1e-3 * f64::from(*tick) - 2e-4;
                hand.sample(&Pose::default(), &Frame::default(), time, 1e-3);
                !hand.present
            });
            assert_eq!(let_go, Some(ticks), "of age {age} s");
        }
    }

    #[test]
    fn frames_rotate_scale_and_translate() {
        let rotation = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), std::f64::consts::FRAC_PI_2);
        let frame = Frame { origin: Vec3::x(), rotation, scale: 2.0 };
        let at = frame.to_scene(Vec3::x());
        assert!((at[0] - 1.0).abs() < 1e-15 && (at[1] - 2.0).abs() < 1e-15);
        assert!((frame.to_device(Vec3::new(0.0, 3.0, 0.0))[0] - 3.0).abs() < 1e-15);
        assert!((frame.to_hand(at) - Vec3::x()).norm() < 1e-15);
    }
}
