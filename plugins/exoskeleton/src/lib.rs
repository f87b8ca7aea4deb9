//! A hand exoskeleton with force feedback on the tips of index and thumb and a tactile array on each (Fontana et al. 2013, Salsedo et
//! al. 2011, as used by Tripicchio, D'Avella and Ruffaldi 2022), over UDP.
//!
//! The publications give the tactile arrays: 5 x 6 pins of at most 73 mN, 2.4 mm in diameter. They do not give pitch, forces, stiffness
//! and workspace; these are parameters, with assumed defaults. The plugin was tested against its twin, never on hardware.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod key;
pub mod link;
mod params;
pub mod receiver;
pub mod wire;

use core::ffi::CStr;
use key::{Key, require_key};
use link::{CommandKind, Link};
use params::{PARAMS, Settings};
use pliant_plugin_api::abi::{DeviceInfo, Output, POSE_VALID, POSE_VELOCITY, Pose};
use pliant_plugin_api::{AsDevice, Device, Fault, Finding, Info, Params, export_plugins};
use std::sync::atomic::{AtomicU64, Ordering};
use wire::{EFFECTOR_COUNT, FINGER_SENSED, FINGER_VELOCITY, FingerCommand};

/// How often a stop and a goodbye are sent: datagrams get lost, and these are not repeated by the next tick.
const STOP_REPEATS: usize = 3;

/// An exoskeleton that is connected.
pub struct Exoskeleton {
    /// Session with the device.
    link: Link,
    /// Limits of the device.
    info: DeviceInfo,
    /// Silence after which the device counts as lost, ns.
    silence_limit_ns: u64,
    /// The force last sent to each fingertip, N, as the bits of an `f64`.
    force_bits: [[AtomicU64; 3]; EFFECTOR_COUNT],
    /// Time at which these forces expire, ns on the host's clock.
    force_expires_ns: AtomicU64,
    /// Forces that were not finite and were replaced by zero.
    forces_rejected: AtomicU64,
    /// Forces that were scaled down to the peak force.
    forces_clamped: AtomicU64,
    /// Calls of `read` that found the last pose expired.
    reads_without_pose: AtomicU64,
}

impl Exoskeleton {
    /// The session with the device.
    pub fn link(&self) -> &Link {
        &self.link
    }

    /// Stores the forces that are rendered (N) and the time at which they expire (ns), for `rendered`.
    fn store_forces(&self, fingers: &[FingerCommand; EFFECTOR_COUNT], expires_ns: u64) {
        for (stored, finger) in self.force_bits.iter().zip(fingers) {
            stored.iter().zip(finger.force).for_each(|(bits, f)| bits.store(f.to_bits(), Ordering::Relaxed));
        }
        self.force_expires_ns.store(expires_ns, Ordering::Relaxed);
    }

    /// The command for one fingertip, within the limits of the device.
    fn limited_command(&self, output: &Output) -> FingerCommand {
        let mut command = FingerCommand::default();
        let norm = output.force.iter().map(|f| f * f).sum::<f64>().sqrt();
        if !output.force.iter().all(|f| f.is_finite()) {
            self.forces_rejected.fetch_add(1, Ordering::Relaxed);
        } else if norm > self.info.peak_force {
            self.forces_clamped.fetch_add(1, Ordering::Relaxed);
            // The norm of finite numbers can overflow.
            let scale = if norm.is_finite() { self.info.peak_force / norm } else { 0.0 };
            command.force = output.force.map(|f| f * scale);
        } else {
            command.force = output.force;
        }
        for (taxel, force) in command.taxels.iter_mut().zip(self.taxel_forces(output)) {
            // False for NaN, which becomes 0.
            *taxel = if *force > 0.0 { force.min(self.info.taxel_force) as f32 } else { 0.0 };
        }
        command
    }

    /// The forces of the taxels of one fingertip, N; empty without a tactile array.
    #[allow(unsafe_code, reason = "reads the array whose length the host takes from `describe`")]
    fn taxel_forces<'a>(&self, output: &'a Output) -> &'a [f64] {
        if output.taxels.is_null() {
            return &[];
        }
        // SAFETY: rows x columns doubles, as described, borrowed for the call of `write`.
        unsafe { core::slice::from_raw_parts(output.taxels, (self.info.taxel_rows * self.info.taxel_columns) as usize) }
    }
}

impl Device for Exoskeleton {
    const INFO: Info = Info {
        id: c"exoskeleton",
        name: c"Hand exoskeleton",
        version: c"0.1.0",
        summary: c"index and thumb with tactile arrays, over UDP",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let settings = Settings::read(params)?;
        let key = settings.key.as_deref().map(Key::from_file).transpose().map_err(Fault::bad_argument)?;
        require_key(settings.peer.ip(), key.as_ref()).map_err(Fault::bad_argument)?;
        let link = Link::new(settings.peer, settings.layout, key).map_err(|e| Fault::io(e.to_string()))?;
        link.connect(settings.connect_timeout).map_err(|e| Fault::io(format!("{e}; {}", params::NO_ANSWER_REMEDY)))?;
        Ok(Self {
            link,
            info: settings.info,
            silence_limit_ns: settings.silence_limit.as_nanos() as u64,
            force_bits: Default::default(),
            force_expires_ns: AtomicU64::new(0),
            forces_rejected: AtomicU64::new(0),
            forces_clamped: AtomicU64::new(0),
            reads_without_pose: AtomicU64::new(0),
        })
    }

    fn describe(&self) -> DeviceInfo {
        self.info
    }

    fn read(&self, time: u64, poses: &mut [Pose]) -> Result<(), Fault> {
        let latest = self.link.receive();
        if latest.age_ns > self.silence_limit_ns {
            return Err(Fault::io("the exoskeleton has fallen silent"));
        }
        self.reads_without_pose.fetch_add(u64::from(!latest.is_valid), Ordering::Relaxed);
        for (pose, finger) in poses.iter_mut().zip(&latest.fingers) {
            let sensed = latest.is_valid && finger.flags & FINGER_SENSED != 0;
            let velocity = if finger.flags & FINGER_VELOCITY != 0 { POSE_VELOCITY } else { 0 };
            *pose = Pose {
                time_ns: time.saturating_sub(latest.age_ns),
                flags: if sensed { POSE_VALID | velocity } else { 0 },
                buttons: finger.buttons,
                position: finger.position,
                orientation: finger.orientation,
                velocity: finger.velocity,
                ..Pose::default()
            };
        }
        Ok(())
    }

    fn write(&self, time: u64, outputs: &[Output]) -> Result<(), Fault> {
        let mut fingers = [FingerCommand::default(); EFFECTOR_COUNT];
        let mut expires_ns = u64::MAX;
        for (finger, output) in fingers.iter_mut().zip(outputs) {
            *finger = self.limited_command(output);
            expires_ns = expires_ns.min(output.valid_until_ns);
        }
        self.store_forces(&fingers, expires_ns);
        self.link.send(&fingers, expires_ns.saturating_sub(time), CommandKind::Render);
        Ok(())
    }

    fn stop(&self) {
        let zero = [FingerCommand::default(); EFFECTOR_COUNT];
        self.store_forces(&zero, 0);
        (0..STOP_REPEATS).for_each(|_| self.link.send(&zero, 0, CommandKind::Stop));
    }

    fn rendered(&self, time: u64, outputs: &mut [Output]) -> Result<(), Fault> {
        let is_valid = time < self.force_expires_ns.load(Ordering::Relaxed);
        for (output, stored) in outputs.iter_mut().zip(&self.force_bits) {
            for (component, bits) in output.force.iter_mut().zip(stored) {
                *component = if is_valid { f64::from_bits(bits.load(Ordering::Relaxed)) } else { 0.0 };
            }
        }
        Ok(())
    }

    fn counter(&self, index: u32) -> Option<(&'static CStr, u64)> {
        let counts = self.link.counts();
        let counters = [
            (c"poses accepted", counts.accepted),
            (c"poses late", counts.late),
            (c"poses duplicate", counts.duplicate),
            (c"poses lost", counts.lost),
            (c"poses stale", counts.stale),
            (c"datagrams malformed", counts.malformed),
            (c"datagrams unauthentic", counts.unauthentic),
            (c"datagrams foreign", counts.foreign),
            (c"reads without a pose", self.reads_without_pose.load(Ordering::Relaxed)),
            (c"commands sent", self.link.sent_count()),
            (c"commands unsent", self.link.unsent_count()),
            (c"forces rejected", self.forces_rejected.load(Ordering::Relaxed)),
            (c"forces clamped", self.forces_clamped.load(Ordering::Relaxed)),
        ];
        counters.get(index as usize).copied()
    }

    fn probe(params: &Params<'_>) -> Vec<Finding> {
        params::probe(params)
    }
}

impl Drop for Exoskeleton {
    fn drop(&mut self) {
        let zero = [FingerCommand::default(); EFFECTOR_COUNT];
        (0..STOP_REPEATS).for_each(|_| self.link.send(&zero, 0, CommandKind::Goodbye));
    }
}

export_plugins!(AsDevice<Exoskeleton>);
