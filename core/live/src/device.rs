//! Interface between the haptic thread and a device.

use crate::guided::Rescaling;
use pliant_host::{Device, DeviceInfo, EffectorOutput, Pose};
use pliant_plugin_api::abi::Status;

/// Emergency stop: sets a device to zero force, from any thread at any time.
pub type StopDevice = Box<dyn Fn() + Send + Sync>;

/// A haptic device: an opened plugin, a [`PointerDevice`](crate::PointerDevice), or a device of a test.
///
/// *Real time*: `read` and `write` may not allocate, lock, log or wait, except where the hardware requires it.
pub trait HapticDevice: Send {
    /// Effectors, rate, limits, workspace and tactile array.
    fn device_info(&self) -> DeviceInfo;

    /// Reads the newest pose of each effector at `time` (ns). Any status but OK means that the device is lost.
    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status;

    /// Sets the outputs that each effector renders from `time` (ns). Any status but OK means that the device is lost.
    fn write(&mut self, time: u64, outputs: &[EffectorOutput<'_>]) -> Status;

    /// The emergency stop of the device.
    fn stop_handle(&self) -> StopDevice;

    /// Whether a tick that begins a few tens of microseconds late is felt. Without such a device the haptic thread sleeps up to its deadlines and does not
    /// spin before them.
    fn needs_exact_ticks(&self) -> bool {
        true
    }

    /// Changes how lengths and forces are scaled, between two ticks; nothing for a device that scales nothing.
    fn rescale(&mut self, _rescaling: &Rescaling) {}

    /// Names and values of the device's counters since it was opened; empty without counters. Not called on the haptic thread.
    fn counters(&self) -> Vec<(String, u64)> {
        Vec::new()
    }

    /// Description of the `status` that `call` returned. Not called on the haptic thread.
    fn describe_status(&self, call: &'static str, status: Status) -> String {
        format!("{call}: {}", status.meaning())
    }
}

impl HapticDevice for Device {
    fn device_info(&self) -> DeviceInfo {
        *Device::device_info(self)
    }

    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        self.read_realtime(time, poses)
    }

    fn write(&mut self, time: u64, outputs: &[EffectorOutput<'_>]) -> Status {
        self.write_realtime(time, outputs)
    }

    fn stop_handle(&self) -> StopDevice {
        let handle = Device::stop_handle(self);
        Box::new(move || handle.stop())
    }

    fn counters(&self) -> Vec<(String, u64)> {
        Device::counters(self)
    }

    fn describe_status(&self, call: &'static str, status: Status) -> String {
        self.check(call, status).err().map_or_else(String::new, |error| error.to_string())
    }
}
