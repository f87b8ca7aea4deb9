//! What the haptic thread needs of a device.

use pliant_host::{Device, DeviceInfo, Output, Pose};
use pliant_plugin_api::abi::Status;

/// Puts a device to zero force, from any thread, at any time.
pub type StopNow = Box<dyn Fn() + Send + Sync>;

/// A device as the haptic thread has it: an opened plugin, a pointer, a test's.
///
/// *Real time*: `read` and `write` may not allocate, lock, log or wait, but for what the hardware itself asks for.
pub trait Haptic: Send {
    /// Its limits.
    fn facts(&self) -> DeviceInfo;

    /// Its newest poses at `time` (ns). Anything but OK: it is lost.
    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status;

    /// What it is to render. Anything but OK: it is lost.
    fn write(&mut self, time: u64, outputs: &[Output<'_>]) -> Status;

    /// Its emergency stop.
    fn stopper(&self) -> StopNow;

    /// What it has counted since it was opened, where it counts; outside of the haptic thread.
    fn counters(&self) -> Vec<(String, u64)> {
        Vec::new()
    }

    /// In words, why `call` gave `status`; outside of the haptic thread.
    fn told(&self, call: &'static str, status: Status) -> String {
        format!("{call}: {}", status.meaning())
    }
}

impl Haptic for Device {
    fn facts(&self) -> DeviceInfo {
        *Device::facts(self)
    }

    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        self.read_now(time, poses)
    }

    fn write(&mut self, time: u64, outputs: &[Output<'_>]) -> Status {
        self.write_now(time, outputs)
    }

    fn stopper(&self) -> StopNow {
        let stopper = Device::stopper(self);
        Box::new(move || stopper.stop())
    }

    fn counters(&self) -> Vec<(String, u64)> {
        Device::counters(self)
    }

    fn told(&self, call: &'static str, status: Status) -> String {
        Device::told(self, call, status).err().map_or_else(String::new, |error| error.to_string())
    }
}
