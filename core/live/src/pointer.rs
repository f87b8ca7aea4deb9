//! A device that a program moves: for a mouse, a keyboard or a window. It renders no force.

use crate::device::{HapticDevice, StopDevice};
use pliant_host::{DeviceInfo, EffectorOutput, Pose};
use pliant_plugin_api::abi::{POSE_VALID, Status};
use pliant_solver::Vec3;
use triple_buffer::{Input, triple_buffer};

/// The device's end: takes the place of a scene's device in [`LiveSession::start_with_devices`](crate::LiveSession::start_with_devices).
pub struct PointerDevice {
    info: DeviceInfo,
    hands: triple_buffer::Output<HandState>,
    force: Input<Vec3>,
}

/// The program's end: moves the hand and reads the force on it.
pub struct PointerHandle {
    hands: Input<HandState>,
    force: triple_buffer::Output<Vec3>,
}

/// Where the hand is.
#[derive(Clone, Copy, Debug, Default)]
struct HandState {
    /// m, in device axes
    position: Vec3,
    /// Bit i is button i.
    buttons: u32,
    present: bool,
}

impl PointerDevice {
    /// A device with the limits `info`, usually those of the device it stands in for, and the handle that moves it.
    pub fn new(info: DeviceInfo) -> (Self, PointerHandle) {
        let (hands, output) = triple_buffer(&HandState::default());
        let (force, felt) = triple_buffer(&Vec3::zeros());
        (Self { info, hands: output, force }, PointerHandle { hands, force: felt })
    }
}

impl PointerHandle {
    /// Moves the hand to `position` (m, device axes) with these buttons (bit i is button i).
    pub fn move_to(&mut self, position: Vec3, buttons: u32) {
        self.hands.write(HandState { position, buttons, present: true });
    }

    /// Takes the hand away: its poses are not valid until the next [`PointerHandle::move_to`].
    pub fn remove(&mut self) {
        self.hands.write(HandState::default());
    }

    /// N (3), the force a real hand would feel, in device axes
    pub fn force(&mut self) -> Vec3 {
        *self.force.read()
    }
}

impl HapticDevice for PointerDevice {
    fn device_info(&self) -> DeviceInfo {
        self.info
    }

    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        let HandState { position, buttons, present } = *self.hands.read();
        let flags = if present { POSE_VALID } else { 0 };
        poses.fill(Pose { time_ns: time, flags, buttons, position: position.into(), ..Pose::default() });
        Status::OK
    }

    fn write(&mut self, _time: u64, outputs: &[EffectorOutput<'_>]) -> Status {
        self.force.write(outputs.first().map_or(Vec3::zeros(), |output| output.force.into()));
        Status::OK
    }

    fn stop_handle(&self) -> StopDevice {
        Box::new(|| {}) // it renders no force
    }
}
