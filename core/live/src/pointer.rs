//! A device controlled by a program, for a mouse, a keyboard or a window. It renders no force.

use crate::device::{HapticDevice, StopDevice};
use nalgebra::UnitQuaternion;
use pliant_host::{DeviceInfo, EffectorOutput, Pose};
use pliant_plugin_api::abi::{POSE_VALID, Status};
use pliant_solver::Vec3;
use triple_buffer::{Input, triple_buffer};

/// The device's end; it replaces a device of the scene in [`LiveSession::start_with_devices`](crate::LiveSession::start_with_devices).
pub struct PointerDevice {
    info: DeviceInfo,
    hands: triple_buffer::Output<Target>,
    force: Input<Vec3>,
    glide: Glide,
}

/// The program's end: moves the hand and reads the force on it.
pub struct PointerHandle {
    hands: Input<Target>,
    force: triple_buffer::Output<Vec3>,
    /// Number of the last target.
    number: u64,
}

/// Target pose of the hand.
#[derive(Clone, Copy, Debug, Default)]
struct Target {
    /// Number of the target, from 1.
    number: u64,
    pose_at: HandPose,
    /// Pressed buttons: bit i is button i.
    buttons: u32,
    present: bool,
    /// Duration of the motion to the target, ns.
    duration: u64,
    /// Whether the buttons change at the end of the motion, and not at its beginning.
    presses_late: bool,
}

/// A pose of the hand in axes of the device.
#[derive(Clone, Copy, Debug)]
struct HandPose {
    /// Position of the hand, m.
    position: Vec3,
    rotation: UnitQuaternion<f64>,
}

impl Default for HandPose {
    fn default() -> Self {
        Self { position: Vec3::zeros(), rotation: UnitQuaternion::identity() }
    }
}

/// The motion from one pose to the next.
#[derive(Clone, Copy, Debug, Default)]
struct Glide {
    /// Number of the target it leads to.
    number: u64,
    from: HandPose,
    /// Time of its beginning, ns.
    began: u64,
    /// Whether a hand was present before.
    present: bool,
    /// Buttons at its beginning.
    buttons: u32,
}

impl Glide {
    /// Buttons on its way to `target` at `time` (ns).
    fn buttons_at(&self, target: &Target, time: u64) -> u32 {
        let is_on_its_way = self.present && time.saturating_sub(self.began) < target.duration;
        if target.presses_late && is_on_its_way { self.buttons } else { target.buttons }
    }

    /// Pose of the hand on its motion to `target` at `time` (ns).
    fn pose_at(&self, target: &Target, time: u64) -> HandPose {
        let since = time.saturating_sub(self.began);
        if !self.present || since >= target.duration {
            return target.pose_at;
        }
        let share = since as f64 / target.duration as f64;
        HandPose {
            position: self.from.position.lerp(&target.pose_at.position, share),
            rotation: self.from.rotation.nlerp(&target.pose_at.rotation, share),
        }
    }
}

impl PointerDevice {
    /// A device with the limits `info`, usually those of the device it stands in for, and the handle that moves it.
    pub fn new(info: DeviceInfo) -> (Self, PointerHandle) {
        let (hands, output) = triple_buffer(&Target::default());
        let (force, felt) = triple_buffer(&Vec3::zeros());
        let device = Self { info, hands: output, force, glide: Glide::default() };
        (device, PointerHandle { hands, force: felt, number: 0 })
    }
}

impl PointerHandle {
    /// Moves the hand at once to `position` (m, in axes of the device) with these buttons (bit i is button i) and no rotation.
    pub fn move_to(&mut self, position: Vec3, buttons: u32) {
        self.glide_to(position, UnitQuaternion::identity(), buttons, 0.0);
    }

    /// Moves the hand to `position` (m) and `rotation`, in axes of the device, at constant speed within `duration` (s): the jumps of a pointer sampled at
    /// sixty frames per second would be perceptible. The buttons change at once.
    pub fn glide_to(&mut self, position: Vec3, rotation: UnitQuaternion<f64>, buttons: u32, duration: f64) {
        self.send(HandPose { position, rotation }, buttons, duration, false);
    }

    /// Like [`PointerHandle::glide_to`], but the buttons change once the hand has arrived: what it presses, it presses there. One call does what would take two
    /// of a program that draws a frame in between.
    pub fn glide_then_press(&mut self, position: Vec3, rotation: UnitQuaternion<f64>, buttons: u32, duration: f64) {
        self.send(HandPose { position, rotation }, buttons, duration, true);
    }

    fn send(&mut self, pose_at: HandPose, buttons: u32, duration: f64, presses_late: bool) {
        self.number += 1;
        let duration = (duration.max(0.0) * 1e9) as u64;
        self.hands.write(Target { number: self.number, pose_at, buttons, present: true, duration, presses_late });
    }

    /// Removes the hand: its poses are invalid until the next [`PointerHandle::move_to`].
    pub fn remove(&mut self) {
        self.number += 1;
        self.hands.write(Target { number: self.number, ..Target::default() });
    }

    /// The force on the hand, in axes of the device, N.
    pub fn force(&mut self) -> Vec3 {
        *self.force.read()
    }
}

impl HapticDevice for PointerDevice {
    fn device_info(&self) -> DeviceInfo {
        self.info
    }

    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        let before = *self.hands.output_buffer();
        let target = *self.hands.read();
        if target.number != self.glide.number {
            let (from, buttons) = (self.glide.pose_at(&before, time), self.glide.buttons_at(&before, time));
            self.glide = Glide { number: target.number, from, began: time, present: before.present, buttons };
        }
        let HandPose { position, rotation } = self.glide.pose_at(&target, time);
        let buttons = self.glide.buttons_at(&target, time);
        let flags = if target.present { POSE_VALID } else { 0 };
        let orientation = rotation.coords.into();
        let position = position.into();
        poses.fill(Pose { time_ns: time, flags, buttons, position, orientation, ..Pose::default() });
        Status::OK
    }

    fn write(&mut self, _time: u64, outputs: &[EffectorOutput<'_>]) -> Status {
        self.force.write(outputs.first().map_or(Vec3::zeros(), |output| output.force.into()));
        Status::OK
    }

    fn stop_handle(&self) -> StopDevice {
        Box::new(|| {}) // it renders no force
    }

    fn needs_exact_ticks(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A device of one effector that renders nothing.
    fn info() -> DeviceInfo {
        DeviceInfo {
            effectors: 1,
            buttons: 32,
            driven_axes: 3,
            rate: 1000.0,
            peak_force: 1.0,
            continuous_force: 1.0,
            stiffness: 1000.0,
            ..DeviceInfo::default()
        }
    }

    fn read(device: &mut PointerDevice, time: u64) -> Pose {
        let mut poses = [Pose::default()];
        assert_eq!(device.read(time, &mut poses), Status::OK);
        poses[0]
    }

    #[test]
    fn a_hand_glides_from_where_it_is_and_its_buttons_change_at_once() {
        let (mut device, mut hand) = PointerDevice::new(info());
        assert_eq!(read(&mut device, 5).flags & POSE_VALID, 0, "no hand yet");
        hand.glide_to(Vec3::x(), UnitQuaternion::identity(), 0, 1e-3);
        assert_eq!(read(&mut device, 10).position, [1.0, 0.0, 0.0], "a new hand has no way to go");
        let turn = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), 0.2);
        hand.glide_to(3.0 * Vec3::x(), turn, 2, 1e-3);
        let begin = read(&mut device, 1_000_000);
        assert_eq!((begin.position, begin.buttons), ([1.0, 0.0, 0.0], 2));
        assert_eq!(read(&mut device, 1_500_000).position, [2.0, 0.0, 0.0]);
        // A new target on the way: from where it is.
        hand.glide_to(Vec3::zeros(), turn, 0, 1e-3);
        assert_eq!(read(&mut device, 1_500_000).position, [2.0, 0.0, 0.0]);
        assert_eq!(read(&mut device, 2_000_000).position, [1.0, 0.0, 0.0]);
        let end = read(&mut device, 9_000_000);
        assert_eq!(end.position, [0.0; 3]);
        assert!((end.orientation[2] - 0.1_f64.sin()).abs() < 1e-12, "{:?}", end.orientation);
        hand.remove();
        assert_eq!(read(&mut device, 9_000_001).flags & POSE_VALID, 0);
    }

    #[test]
    fn a_hand_that_presses_when_it_arrives_keeps_its_buttons_on_the_way() {
        let (mut device, mut hand) = PointerDevice::new(info());
        hand.glide_then_press(Vec3::x(), UnitQuaternion::identity(), 1, 1e-3);
        assert_eq!(read(&mut device, 5).buttons, 1, "a new hand has no way to go");
        hand.glide_then_press(2.0 * Vec3::x(), UnitQuaternion::identity(), 4, 1e-3);
        assert_eq!(read(&mut device, 1_000_000).buttons, 1);
        assert_eq!(read(&mut device, 1_999_999).buttons, 1);
        // Another target before it has arrived: what was to be pressed has not been.
        hand.glide_then_press(3.0 * Vec3::x(), UnitQuaternion::identity(), 8, 1e-3);
        assert_eq!(read(&mut device, 1_999_999).buttons, 1);
        let pose = read(&mut device, 2_999_999);
        assert_eq!((pose.buttons, pose.position), (8, [3.0, 0.0, 0.0]));
        hand.glide_to(Vec3::zeros(), UnitQuaternion::identity(), 0, 1e-3);
        assert_eq!(read(&mut device, 3_000_000).buttons, 0, "and otherwise they change at once");
    }
}
