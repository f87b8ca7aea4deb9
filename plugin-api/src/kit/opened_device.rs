//! Safe calls into a device under test.
#![allow(unsafe_code, reason = "plays the host")]

use super::opened::Opened;
use crate::abi::{self, DeviceInfo, Output, Pose};
use crate::fault::Fault;
use core::ptr::null;

/// An opened device and its tables.
pub(super) struct OpenedDevice {
    opened: Opened,
    table: &'static abi::Device,
    rendered: Option<&'static abi::Rendered>,
    pub(super) facts: DeviceInfo,
}

/// An output with a force (N) until a time (ns).
pub(super) fn output(force: [f64; 3], valid_until_ns: u64) -> Output {
    Output { size: size_of::<Output>(), force, torque: [0.0; 3], taxels: null(), valid_until_ns }
}

/// Effectors a device may have.
const MOST: u32 = 8;

// SAFETY of every call below: [servo & active] or less, on one thread, with buffers for every effector.
impl OpenedDevice {
    pub(super) fn new(opened: Opened) -> Result<Self, Fault> {
        let missing = || Fault::bad_argument("`pliant.device/1` is not offered or has a null in it");
        let table: &'static abi::Device = opened.extension(abi::DEVICE)?.ok_or_else(missing)?;
        let describe = table.describe.ok_or_else(missing)?;
        if table.read.is_none() || table.write.is_none() || table.stop.is_none() {
            return Err(missing());
        }
        // SAFETY: a struct of numbers, to be filled.
        let mut facts: DeviceInfo = unsafe { core::mem::zeroed() };
        facts.size = size_of::<DeviceInfo>();
        // SAFETY: see above.
        opened.done(unsafe { describe(opened.raw(), &mut facts) })?;
        if !(1..=MOST).contains(&facts.effectors) {
            return Err(Fault::bad_argument(format!("{} effectors; allowed is 1 to {MOST}", facts.effectors)));
        }
        let rendered = opened.extension(abi::RENDERED)?;
        Ok(Self { opened, table, rendered, facts })
    }

    pub(super) fn read(&self, time: u64) -> Result<Vec<Pose>, Fault> {
        let mut poses = vec![Pose::default(); self.facts.effectors as usize];
        let read = self.table.read.expect("checked");
        // SAFETY: see above.
        self.opened.done(unsafe { read(self.opened.raw(), time, poses.as_mut_ptr(), poses.len()) })?;
        Ok(poses)
    }

    /// The same output for every effector.
    pub(super) fn write(&self, time: u64, output: Output) -> Result<(), Fault> {
        let outputs = vec![output; self.facts.effectors as usize];
        let write = self.table.write.expect("checked");
        // SAFETY: see above.
        self.opened.done(unsafe { write(self.opened.raw(), time, outputs.as_ptr(), outputs.len()) })
    }

    pub(super) fn stop(&self) -> Result<(), Fault> {
        let stop = self.table.stop.expect("checked");
        // SAFETY: see above.
        self.opened.done(unsafe { stop(self.opened.raw()) })
    }

    /// N, the largest force it renders; `None` where it does not say.
    pub(super) fn renders(&self, time: u64) -> Result<Option<f64>, Fault> {
        let Some(rendered) = self.rendered.and_then(|r| r.rendered) else { return Ok(None) };
        let mut outputs = vec![output([0.0; 3], 0); self.facts.effectors as usize];
        // SAFETY: see above.
        match unsafe { rendered(self.opened.raw(), time, outputs.as_mut_ptr(), outputs.len()) } {
            abi::Status::UNSUPPORTED => Ok(None),
            status => {
                self.opened.done(status)?;
                let size = |o: &Output| o.force.iter().map(|f| f * f).sum::<f64>().sqrt();
                Ok(Some(outputs.iter().map(size).fold(0.0, |m, f| if f > m || f.is_nan() { f } else { m })))
            }
        }
    }
}
