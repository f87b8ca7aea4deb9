//! A hand that presses 3 mm into what is under it and stays.

use crate::{AFTER, fault, info};
use pliant_plugin_api::abi::{DeviceInfo, Output, POSE_VALID, Pose};
use pliant_plugin_api::{Device, Fault, Info, Param, Params};

/// A finger.
pub struct Finger<const F: u8> {
    after: f64,
}

impl<const F: u8> Device for Finger<F> {
    const INFO: Info = info(
        match F {
            fault::PANIC => c"panics-in-read",
            fault::NOT_A_NUMBER => c"places-not-a-number",
            fault::REFUSES => c"lost-in-read",
            _ => c"sound-finger",
        },
        const { &[AFTER] as &[Param] },
    );

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        Ok(Self { after: params.number("after") })
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
            peak_force: 3.3,
            continuous_force: 1.0,
            stiffness: 700.0,
            damping: 5.0,
            resolution: 0.0,
            workspace: [-0.1, -0.1, -0.1, 0.1, 0.1, 0.1],
            taxel_pitch: 0.0,
            taxel_force: 0.0,
        }
    }

    fn read(&self, time: u64, poses: &mut [Pose]) -> Result<(), Fault> {
        let seconds = time as f64 * 1e-9;
        let due = seconds >= self.after;
        assert!(!(due && F == fault::PANIC), "panicked on purpose, in read");
        if due && F == fault::REFUSES {
            return Err(Fault::io("unplugged on purpose"));
        }
        let height = if due && F == fault::NOT_A_NUMBER { f64::NAN } else { (0.006 - seconds).max(0.001) };
        let position = [0.0, 0.0, height];
        poses.fill(Pose { time_ns: time, flags: POSE_VALID, position, ..Pose::default() });
        Ok(())
    }

    fn write(&self, _: u64, _: &[Output]) -> Result<(), Fault> {
        Ok(())
    }

    fn stop(&self) {}
}
