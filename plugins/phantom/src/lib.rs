//! Phantom arms (Omni, Touch and their kin) through the HDAPI of OpenHaptics.
//!
//! The vendor's library is loaded at run time, so nothing of it is needed to build. The driver's own servo thread talks to the
//! arm; `read` and `write` exchange whole values with it and never wait. Tested against a twin behind a stand-in for the
//! driver library, never on hardware.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod driver;
pub mod errors;
pub mod hd;
pub mod locale;
mod params;
pub mod servo;
pub mod snapshot;

use core::ffi::CStr;
use driver::Driver;
use params::{PARAMS, Settings};
use pliant_plugin_api::abi::{DeviceInfo, Output, POSE_VALID, POSE_VELOCITY, Pose};
use pliant_plugin_api::{AsDevice, Device, Fault, Finding, Info, Params, export_plugins};
use std::sync::atomic::{AtomicU64, Ordering};

/// One or two arms.
pub struct Phantom {
    driver: Driver,
    /// ns, without a pose after which it is lost
    patience: u64,
    /// ns, on the driver's clock, when every arm had a pose last
    seen: AtomicU64,
    /// ns, on the host's clock, until when the last write holds
    until: AtomicU64,
    /// N, as bits
    wanted: [[AtomicU64; 3]; servo::MOST_ARMS],
    stalls: AtomicU64,
}

/// ns, a servo loop that has not ticked for this long has stalled: its pose is none.
const STALLED: u64 = 50_000_000;
/// ns, the longest a force holds, whatever the host says
const MOST_VALID: u64 = 200_000_000;

impl Phantom {
    /// What the arms are given and what happened to them.
    pub fn driver(&self) -> &Driver {
        &self.driver
    }
}

impl Device for Phantom {
    const INFO: Info = Info {
        id: c"phantom",
        name: c"Phantom arm",
        version: c"0.1.0",
        summary: c"one or two arms through OpenHaptics",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let settings = Settings::read(params)?;
        let patience = (settings.lost_after * 1e9) as u64;
        let driver = Driver::open(settings).map_err(Fault::io)?;
        let seen = driver.servo().now();
        Ok(Self {
            driver,
            patience,
            seen: AtomicU64::new(seen),
            until: AtomicU64::new(0),
            wanted: Default::default(),
            stalls: AtomicU64::new(0),
        })
    }

    fn describe(&self) -> DeviceInfo {
        self.driver.facts
    }

    fn read(&self, time: u64, poses: &mut [Pose]) -> Result<(), Fault> {
        let servo = self.driver.servo();
        let now = servo.now();
        let mut all = true;
        for (pose, arm) in poses.iter_mut().zip(&servo.arms) {
            let state = arm.state().filter(|s| now.saturating_sub(s.time) < STALLED);
            *pose = Pose::default();
            let Some(state) = state else {
                all = false;
                continue;
            };
            let resting = state.inkwell && servo.rests;
            *pose = Pose {
                time_ns: time.saturating_sub(now.saturating_sub(state.time)),
                flags: if resting { 0 } else { POSE_VALID | POSE_VELOCITY },
                buttons: state.buttons,
                position: state.position,
                orientation: state.orientation,
                velocity: state.velocity,
                ..Pose::default()
            };
        }
        if all {
            self.seen.store(now, Ordering::Relaxed);
        } else {
            self.stalls.fetch_add(1, Ordering::Relaxed);
            if now.saturating_sub(self.seen.load(Ordering::Relaxed)) > self.patience {
                return Err(Fault::io("an arm has been without a pose for too long"));
            }
        }
        Ok(())
    }

    fn write(&self, time: u64, outputs: &[Output]) -> Result<(), Fault> {
        let servo = self.driver.servo();
        let now = servo.now();
        let mut until = u64::MAX;
        for ((arm, output), wanted) in servo.arms.iter().zip(outputs).zip(&self.wanted) {
            let valid = output.valid_until_ns.saturating_sub(time).min(MOST_VALID);
            until = until.min(output.valid_until_ns);
            arm.command(output.force, now + valid);
            wanted.iter().zip(output.force).for_each(|(to, f)| to.store(f.to_bits(), Ordering::Relaxed));
        }
        self.until.store(until, Ordering::Relaxed);
        Ok(())
    }

    fn stop(&self) {
        self.until.store(0, Ordering::Relaxed);
        self.driver.servo().arms.iter().for_each(servo::Arm::stop);
    }

    fn rendered(&self, time: u64, outputs: &mut [Output]) -> Result<(), Fault> {
        let holds = time < self.until.load(Ordering::Relaxed);
        let peak = self.driver.facts.peak_force;
        for (output, wanted) in outputs.iter_mut().zip(&self.wanted) {
            let force: [f64; 3] = std::array::from_fn(|c| f64::from_bits(wanted[c].load(Ordering::Relaxed)));
            let size = force.iter().map(|f| f * f).sum::<f64>().sqrt();
            let scale = if !holds || !size.is_finite() { 0.0 } else { (peak / size).min(1.0) };
            output.force = if scale > 0.0 { force.map(|f| scale * f) } else { [0.0; 3] };
        }
        Ok(())
    }

    fn counter(&self, index: u32) -> Option<(&'static CStr, u64)> {
        let of = |i: usize, what: fn(&servo::Counts) -> &AtomicU64| {
            what(&self.driver.servo().arms[i].counts).load(Ordering::Relaxed)
        };
        let both = |what: fn(&servo::Counts) -> &AtomicU64| (0..servo::MOST_ARMS).map(|i| of(i, what)).sum();
        let newest = |i: usize| u64::from(self.driver.servo().arms[i].counts.newest.load(Ordering::Relaxed));
        let all = [
            (c"servo ticks", both(|c| &c.ticks)),
            (c"force errors", both(|c| &c.force)),
            (c"losses", both(|c| &c.lost)),
            (c"usage and frame errors", both(|c| &c.usage)),
            (c"recoveries", both(|c| &c.recovered)),
            (c"reads without a pose", self.stalls.load(Ordering::Relaxed)),
            (c"newest error", newest(0).max(newest(1))),
        ];
        all.get(index as usize).copied()
    }

    fn probe(params: &Params<'_>) -> Vec<Finding> {
        params::probe(params)
    }
}

export_plugins!(AsDevice<Phantom>);
