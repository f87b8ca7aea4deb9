//! A hand for whoever has no device: a mouse, a keyboard or a program says where it is, and feels nothing.

use super::haptic::{Haptic, StopNow};
use pliant_host::{DeviceInfo, Output, Pose};
use pliant_plugin_api::abi::{POSE_VALID, Status};
use pliant_solver::V3;
use triple_buffer::{Input, triple_buffer};

/// The device's end: takes the place of a scene's device, with its limits.
pub struct Pointer {
    facts: DeviceInfo,
    places: triple_buffer::Output<Place>,
    force: Input<V3>,
}

/// The other end, for a window.
pub struct PointerHand {
    places: Input<Place>,
    force: triple_buffer::Output<V3>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Place {
    position: V3,
    buttons: u32,
    there: bool,
}

impl Pointer {
    /// One that has the limits of the device it stands in for.
    pub fn new(facts: DeviceInfo) -> (Self, PointerHand) {
        let (places, output) = triple_buffer(&Place::default());
        let (force, felt) = triple_buffer(&[0.0; 3]);
        (Self { facts, places: output, force }, PointerHand { places, force: felt })
    }
}

impl PointerHand {
    /// It is at `position` (m, device axes), with these buttons.
    pub fn go(&mut self, position: V3, buttons: u32) {
        self.places.write(Place { position, buttons, there: true });
    }

    /// It is not there any more.
    pub fn leave(&mut self) {
        self.places.write(Place::default());
    }

    /// N, what a real hand would feel, device axes
    pub fn force(&mut self) -> V3 {
        *self.force.read()
    }
}

impl Haptic for Pointer {
    fn facts(&self) -> DeviceInfo {
        self.facts
    }

    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        let Place { position, buttons, there } = *self.places.read();
        let flags = if there { POSE_VALID } else { 0 };
        poses.fill(Pose { time_ns: time, flags, buttons, position, ..Pose::default() });
        Status::OK
    }

    fn write(&mut self, _time: u64, outputs: &[Output<'_>]) -> Status {
        self.force.write(outputs.first().map_or([0.0; 3], |output| output.force));
        Status::OK
    }

    fn stopper(&self) -> StopNow {
        Box::new(|| {}) // it moves nobody
    }
}
