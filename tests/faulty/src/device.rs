//! A hand that presses 3 mm into what is under it and stays.

use crate::{AFTER, fault, info};
use pliant_plugin_api::abi::{DeviceInfo, Output, POSE_VALID, Pose};
use pliant_plugin_api::{Device, Fault, Info, Param, Params};
use std::sync::Mutex;

/// A finger.
pub struct Finger<const F: u8> {
    after: f64,
    /// N, and until when, ns: what is rendered.
    force: Mutex<([f64; 3], u64)>,
}

/// What the instance before rendered.
static BEFORE: Mutex<([f64; 3], u64)> = Mutex::new(([0.0; 3], 0));
/// N
const PEAK: f64 = 3.3;

impl<const F: u8> Device for Finger<F> {
    const INFO: Info = info(
        match F {
            fault::PANIC => c"panics-in-read",
            fault::NOT_A_NUMBER => c"places-not-a-number",
            fault::REFUSES => c"lost-in-read",
            fault::LIMITS_UPSIDE_DOWN => c"limits-upside-down",
            fault::LEAVES_WORKSPACE => c"leaves-workspace",
            fault::OVER_PEAK => c"over-peak",
            fault::IGNORES_STOP => c"ignores-stop",
            fault::NEVER_EXPIRES => c"never-expires",
            fault::OUTLIVES_ITSELF => c"outlives-itself",
            _ => c"sound-finger",
        },
        const { &[AFTER] as &[Param] },
    );

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let before = BEFORE.lock().map_or(([0.0; 3], 0), |b| *b);
        let force = if F == fault::OUTLIVES_ITSELF { before } else { ([0.0; 3], 0) };
        Ok(Self { after: params.number("after"), force: Mutex::new(force) })
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
            continuous_force: if F == fault::LIMITS_UPSIDE_DOWN { 2.0 * PEAK } else { 1.0 },
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
        let aside = if F == fault::LEAVES_WORKSPACE { 0.2 } else { 0.0 };
        let position = [aside, 0.0, height];
        poses.fill(Pose { time_ns: time, flags: POSE_VALID, position, ..Pose::default() });
        Ok(())
    }

    fn write(&self, _: u64, outputs: &[Output]) -> Result<(), Fault> {
        let mut force = outputs[0].force;
        let size = force.iter().map(|f| f * f).sum::<f64>().sqrt();
        if !size.is_finite() {
            force = [0.0; 3];
        } else if size > PEAK && F != fault::OVER_PEAK {
            force = force.map(|f| f * PEAK / size);
        }
        self.set((force, outputs[0].valid_until_ns));
        Ok(())
    }

    fn stop(&self) {
        if F != fault::IGNORES_STOP {
            self.set(([0.0; 3], 0));
        }
    }

    fn rendered(&self, time: u64, outputs: &mut [Output]) -> Result<(), Fault> {
        let (force, until) = self.force.lock().map_or(([0.0; 3], 0), |f| *f);
        let stale = time > until && F != fault::NEVER_EXPIRES;
        outputs[0].force = if stale { [0.0; 3] } else { force };
        Ok(())
    }
}

impl<const F: u8> Finger<F> {
    fn set(&self, force: ([f64; 3], u64)) {
        for to in [&self.force, &BEFORE] {
            if let Ok(mut to) = to.lock() {
                *to = force;
            }
        }
    }
}
