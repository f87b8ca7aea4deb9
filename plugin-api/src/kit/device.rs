//! Safe calls into a device under test.
#![allow(unsafe_code, reason = "plays the host")]

use super::guarded::Guards;
use super::instance::TestInstance;
use crate::abi::{self, DeviceInfo, Output, Pose};
use crate::fault::Fault;
use core::ptr::null;

/// An active device and its tables.
pub(super) struct TestDevice {
    instance: TestInstance,
    table: &'static abi::Device,
    rendered: Option<&'static abi::Rendered>,
    pub(super) info: DeviceInfo,
    pub(super) guards: Guards,
}

/// An output with a force (N), valid until a time (ns).
pub(super) fn output(force: [f64; 3], valid_until_ns: u64) -> Output {
    Output { size: size_of::<Output>(), force, torque: [0.0; 3], taxels: null(), valid_until_ns }
}

/// The most effectors a device may have, as in the host.
const MAX_EFFECTORS: u32 = 8;

// SAFETY of every call below: [servo & active] or less, on one thread, with buffers for every effector.
impl TestDevice {
    /// Looks up the tables and asks for the device's limits.
    pub(super) fn new(instance: TestInstance) -> Result<Self, Fault> {
        let missing = || Fault::bad_argument("`pliant.device/1` is not offered or has a null in it");
        let table: &'static abi::Device = instance.extension(abi::DEVICE)?.ok_or_else(missing)?;
        let describe = table.describe.ok_or_else(missing)?;
        if table.read.is_none() || table.write.is_none() || table.stop.is_none() {
            return Err(missing());
        }
        // SAFETY: a struct of numbers, to be filled.
        let mut info: DeviceInfo = unsafe { core::mem::zeroed() };
        info.size = size_of::<DeviceInfo>();
        // SAFETY: see above.
        instance.check(unsafe { describe(instance.raw(), &mut info) })?;
        if !(1..=MAX_EFFECTORS).contains(&info.effectors) {
            return Err(Fault::bad_argument(format!("{} effectors; allowed is 1 to {MAX_EFFECTORS}", info.effectors)));
        }
        let rendered = instance.extension(abi::RENDERED)?;
        Ok(Self { instance, table, rendered, info, guards: Guards::default() })
    }

    /// Bytes that `describe` writes past the end of the struct of a 1.0 host, and the size it then states.
    pub(super) fn describe_for_1_0(&self) -> Result<(usize, usize), Fault> {
        const UNTOUCHED: u8 = 0xa5;
        // SAFETY: a struct of numbers.
        let mut info: DeviceInfo = unsafe { core::mem::zeroed() };
        info.peak_torque = f64::from_ne_bytes([UNTOUCHED; 8]);
        info.size = core::mem::offset_of!(DeviceInfo, peak_torque);
        let describe = self.table.describe.expect("checked");
        // SAFETY: see above; the struct is as long as the newest one.
        self.instance.check(unsafe { describe(self.instance.raw(), &mut info) })?;
        let written = info.peak_torque.to_ne_bytes().iter().filter(|byte| **byte != UNTOUCHED).count();
        Ok((written, info.size))
    }

    /// One pose per effector.
    pub(super) fn read(&self, time_ns: u64) -> Result<Vec<Pose>, Fault> {
        let mut poses = self.guards.around("poses", &vec![Pose::default(); self.info.effectors as usize]);
        let read = self.table.read.expect("checked");
        // SAFETY: see above.
        self.instance.check(unsafe { read(self.instance.raw(), time_ns, poses.as_mut_ptr(), poses.len()) })?;
        self.guards.look_at_output("read", "poses", &poses);
        Ok(poses.array().to_vec())
    }

    /// Sets the same output for every effector.
    pub(super) fn write(&self, time_ns: u64, output: Output) -> Result<(), Fault> {
        let outputs = self.guards.around("outputs", &vec![output; self.info.effectors as usize]);
        let write = self.table.write.expect("checked");
        // SAFETY: see above.
        let status = unsafe { write(self.instance.raw(), time_ns, outputs.as_ptr(), outputs.len()) };
        self.guards.look_at_input("write", "outputs", &outputs);
        self.instance.check(status)
    }

    /// Calls the device's `stop`.
    pub(super) fn stop(&self) -> Result<(), Fault> {
        let stop = self.table.stop.expect("checked");
        // SAFETY: see above.
        self.instance.check(unsafe { stop(self.instance.raw()) })
    }

    /// The largest force an effector really renders, N; `None` where the device cannot tell.
    pub(super) fn rendered_force(&self, time_ns: u64) -> Result<Option<f64>, Fault> {
        let Some(rendered) = self.rendered.and_then(|r| r.rendered) else { return Ok(None) };
        let mut outputs = self.guards.around("outputs", &vec![output([0.0; 3], 0); self.info.effectors as usize]);
        // SAFETY: see above.
        let status = unsafe { rendered(self.instance.raw(), time_ns, outputs.as_mut_ptr(), outputs.len()) };
        self.guards.look_at_output("rendered", "outputs", &outputs);
        match status {
            abi::Status::UNSUPPORTED => Ok(None),
            status => {
                self.instance.check(status)?;
                let norm = |o: &Output| o.force.iter().map(|f| f * f).sum::<f64>().sqrt();
                Ok(Some(outputs.array().iter().map(norm).fold(0.0, |m, f| if f > m || f.is_nan() { f } else { m })))
            }
        }
    }
}
