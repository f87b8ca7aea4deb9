//! A device whose hand goes down from 6 mm to 1 mm and stays.

use crate::{AFTER, fault, info};
use pliant_plugin_api::abi::{DeviceInfo, Output, POSE_VALID, Pose};
use pliant_plugin_api::{Device, Fault, Info, Param, Params};
use std::sync::Mutex;

/// A device with the fault `F` (see [`fault`]).
pub struct FingerDevice<const F: u8> {
    /// s
    after: f64,
    rendered: Mutex<Rendered>,
}

/// A force and the time it ends.
#[derive(Clone, Copy)]
struct Rendered {
    /// N
    force: [f64; 3],
    valid_until_ns: u64,
}

const NO_FORCE: Rendered = Rendered { force: [0.0; 3], valid_until_ns: 0 };

/// What the last instance rendered, for [`fault::KEEPS_FORCE_WHEN_REOPENED`].
static LAST_INSTANCE: Mutex<Rendered> = Mutex::new(NO_FORCE);
/// Peak force, N.
const PEAK: f64 = 3.3;

impl<const F: u8> Device for FingerDevice<F> {
    const INFO: Info = info(
        match F {
            fault::PANIC => c"panics-in-read",
            fault::NAN => c"positions-not-a-number",
            fault::REFUSES => c"lost-in-read",
            fault::LIMITS_REVERSED => c"limits-reversed",
            fault::LEAVES_WORKSPACE => c"leaves-workspace",
            fault::OVER_PEAK => c"over-peak",
            fault::IGNORES_STOP => c"ignores-stop",
            fault::NEVER_EXPIRES => c"never-expires",
            fault::KEEPS_FORCE_WHEN_REOPENED => c"keeps-force-when-reopened",
            fault::POSE_PAST => c"pose-past",
            _ => c"sound-finger",
        },
        const { &[AFTER] as &[Param] },
    );

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let last = LAST_INSTANCE.lock().map_or(NO_FORCE, |last| *last);
        let rendered = if F == fault::KEEPS_FORCE_WHEN_REOPENED { last } else { NO_FORCE };
        Ok(Self { after: params.number("after"), rendered: Mutex::new(rendered) })
    }

    fn describe(&self) -> DeviceInfo {
        DeviceInfo {
            size: size_of::<DeviceInfo>(),
            effectors: 1,
            buttons: 0,
            driven_axes: 3,
            taxel_rows: 0,
            taxel_columns: 0,
            rate: 1000.0,
            peak_force: PEAK,
            continuous_force: if F == fault::LIMITS_REVERSED { 2.0 * PEAK } else { 1.0 },
            stiffness: 700.0,
            damping: 5.0,
            resolution: 0.0,
            workspace: [-0.1, -0.1, -0.1, 0.1, 0.1, 0.1],
            taxel_pitch: 0.0,
            taxel_force: 0.0,
            peak_torque: 0.0,
        }
    }

    fn read(&self, time_ns: u64, poses: &mut [Pose]) -> Result<(), Fault> {
        let seconds = time_ns as f64 * 1e-9;
        let due = seconds >= self.after;
        assert!(!(due && F == fault::PANIC), "panicked on purpose, in read");
        if due && F == fault::REFUSES {
            return Err(Fault::io("unplugged on purpose"));
        }
        let height = if due && F == fault::NAN { f64::NAN } else { (0.006 - seconds).max(0.001) };
        let aside = if F == fault::LEAVES_WORKSPACE { 0.2 } else { 0.0 };
        let position = [aside, 0.0, height];
        if F == fault::POSE_PAST {
            let behind = poses.as_mut_ptr().wrapping_add(poses.len());
            crate::write_same(behind.wrapping_byte_add(std::mem::offset_of!(Pose, position)).cast());
        }
        poses.fill(Pose { time_ns, flags: POSE_VALID, position, ..Pose::default() });
        Ok(())
    }

    fn write(&self, _: u64, outputs: &[Output]) -> Result<(), Fault> {
        let mut force = outputs[0].force;
        let norm = force.iter().map(|f| f * f).sum::<f64>().sqrt();
        if !norm.is_finite() {
            force = [0.0; 3];
        } else if norm > PEAK && F != fault::OVER_PEAK {
            force = force.map(|f| f * PEAK / norm);
        }
        self.set(Rendered { force, valid_until_ns: outputs[0].valid_until_ns });
        Ok(())
    }

    fn stop(&self) {
        if F != fault::IGNORES_STOP {
            self.set(NO_FORCE);
        }
    }

    fn rendered(&self, time_ns: u64, outputs: &mut [Output]) -> Result<(), Fault> {
        let rendered = self.rendered.lock().map_or(NO_FORCE, |rendered| *rendered);
        let expired = time_ns > rendered.valid_until_ns && F != fault::NEVER_EXPIRES;
        outputs[0].force = if expired { [0.0; 3] } else { rendered.force };
        Ok(())
    }
}

impl<const F: u8> FingerDevice<F> {
    /// Renders from now on; the device that keeps its force remembers it for the next instance.
    fn set(&self, rendered: Rendered) {
        let targets = [&self.rendered, &LAST_INSTANCE];
        // Tests that run side by side share the library: another device must not disturb this one.
        let count = if F == fault::KEEPS_FORCE_WHEN_REOPENED { 2 } else { 1 };
        for target in &targets[..count] {
            if let Ok(mut target) = target.lock() {
                *target = rendered;
            }
        }
    }
}
