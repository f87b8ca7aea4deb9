//! Phantom arms (Omni, Touch and related models) through the HDAPI of OpenHaptics.
//!
//! The vendor's library is loaded at run time, so nothing of it is needed to build. The driver's own servo thread reads and writes the
//! arm; `read` and `write` exchange whole states with it and never wait. The plugin was tested with a replacement of the driver library
//! and a simulated arm behind it, never on hardware.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod arm;
pub mod driver;
pub mod errors;
pub mod hd;
pub mod locale;
mod params;
mod rotation;
pub mod seqlock;
pub mod servo;
mod setup;

use arm::{Arm, ArmCounters};
use core::ffi::CStr;
use driver::Driver;
use params::{PARAMS, Settings};
use pliant_plugin_api::abi::{DeviceInfo, Output, POSE_VALID, POSE_VELOCITY, Pose};
use pliant_plugin_api::{AsDevice, Device, Fault, Finding, Info, Params, export_plugins};
use servo::MAX_ARMS;
use std::sync::atomic::{AtomicU64, Ordering};

/// Age of a state from which on it is not a valid pose, ns: the servo loop has stalled.
const STALL_LIMIT_NS: u64 = 50_000_000;
/// Longest validity of a force, ns, whatever the host says.
const MAX_VALID_NS: u64 = 200_000_000;

/// One or two arms.
pub struct Phantom {
    driver: Driver,
    /// Time without a pose after which the device counts as lost, ns.
    loss_limit_ns: u64,
    /// When every arm last had a pose, ns on the driver's clock.
    last_pose_ns: AtomicU64,
    /// The force last written for each arm, N, as the bits of an `f64`.
    force_bits: [[AtomicU64; 3]; MAX_ARMS],
    /// When it expires, ns on the host's clock.
    force_expires_ns: AtomicU64,
    /// Calls of `read` in which an arm had no pose.
    reads_without_pose: AtomicU64,
}

impl Phantom {
    /// The open driver.
    pub fn driver(&self) -> &Driver {
        &self.driver
    }

    /// The sum of a counter over the arms.
    fn total(&self, counter: fn(&ArmCounters) -> &AtomicU64) -> u64 {
        self.driver.servo().arms.iter().map(|arm| counter(&arm.counters).load(Ordering::Relaxed)).sum()
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
        let loss_limit_ns = settings.loss_limit.as_nanos() as u64;
        let driver = Driver::open(settings).map_err(Fault::io)?;
        let now_ns = driver.servo().now_ns();
        Ok(Self {
            driver,
            loss_limit_ns,
            last_pose_ns: AtomicU64::new(now_ns),
            force_bits: Default::default(),
            force_expires_ns: AtomicU64::new(0),
            reads_without_pose: AtomicU64::new(0),
        })
    }

    fn describe(&self) -> DeviceInfo {
        self.driver.info()
    }

    fn read(&self, time: u64, poses: &mut [Pose]) -> Result<(), Fault> {
        let servo = self.driver.servo();
        let now_ns = servo.now_ns();
        let mut all_valid = true;
        for (pose, arm) in poses.iter_mut().zip(&servo.arms) {
            let state = arm.state().filter(|state| now_ns.saturating_sub(state.time_ns) < STALL_LIMIT_NS);
            let Some(state) = state else {
                *pose = Pose::default();
                all_valid = false;
                continue;
            };
            let is_resting = state.in_inkwell && servo.inkwell_disables_force;
            *pose = Pose {
                time_ns: time.saturating_sub(now_ns.saturating_sub(state.time_ns)),
                flags: if is_resting { 0 } else { POSE_VALID | POSE_VELOCITY },
                buttons: state.buttons,
                position: state.position,
                orientation: state.orientation,
                velocity: state.velocity,
                ..Pose::default()
            };
        }
        if all_valid {
            self.last_pose_ns.store(now_ns, Ordering::Relaxed);
        } else {
            self.reads_without_pose.fetch_add(1, Ordering::Relaxed);
            if now_ns.saturating_sub(self.last_pose_ns.load(Ordering::Relaxed)) > self.loss_limit_ns {
                return Err(Fault::io("an arm has been without a pose for too long"));
            }
        }
        Ok(())
    }

    fn write(&self, time: u64, outputs: &[Output]) -> Result<(), Fault> {
        let servo = self.driver.servo();
        let now_ns = servo.now_ns();
        let mut expires_ns = u64::MAX;
        for ((arm, output), stored) in servo.arms.iter().zip(outputs).zip(&self.force_bits) {
            let valid_ns = output.valid_until_ns.saturating_sub(time).min(MAX_VALID_NS);
            expires_ns = expires_ns.min(output.valid_until_ns);
            arm.command(output.force, now_ns + valid_ns);
            stored.iter().zip(output.force).for_each(|(bits, f)| bits.store(f.to_bits(), Ordering::Relaxed));
        }
        self.force_expires_ns.store(expires_ns, Ordering::Relaxed);
        Ok(())
    }

    fn stop(&self) {
        self.force_expires_ns.store(0, Ordering::Relaxed);
        self.driver.servo().arms.iter().for_each(Arm::stop);
    }

    fn rendered(&self, time: u64, outputs: &mut [Output]) -> Result<(), Fault> {
        let is_valid = time < self.force_expires_ns.load(Ordering::Relaxed);
        let peak_force = self.driver.info().peak_force;
        for (output, stored) in outputs.iter_mut().zip(&self.force_bits) {
            let force: [f64; 3] = std::array::from_fn(|c| f64::from_bits(stored[c].load(Ordering::Relaxed)));
            let norm = force.iter().map(|f| f * f).sum::<f64>().sqrt();
            let scale = if !is_valid || !norm.is_finite() { 0.0 } else { (peak_force / norm).min(1.0) };
            output.force = if scale > 0.0 { force.map(|f| scale * f) } else { [0.0; 3] };
        }
        Ok(())
    }

    fn counter(&self, index: u32) -> Option<(&'static CStr, u64)> {
        let newest_codes = self.driver.servo().arms.iter().map(|arm| arm.counters.newest_code.load(Ordering::Relaxed));
        let counters = [
            (c"servo ticks", self.total(|c| &c.ticks)),
            (c"force errors", self.total(|c| &c.force_errors)),
            (c"losses", self.total(|c| &c.losses)),
            (c"usage and frame errors", self.total(|c| &c.usage_errors)),
            (c"recoveries", self.total(|c| &c.recoveries)),
            (c"reads without a pose", self.reads_without_pose.load(Ordering::Relaxed)),
            (c"newest error", newest_codes.max().map_or(0, u64::from)),
        ];
        counters.get(index as usize).copied()
    }

    fn probe(params: &Params<'_>) -> Vec<Finding> {
        params::probe(params)
    }
}

export_plugins!(AsDevice<Phantom>);
