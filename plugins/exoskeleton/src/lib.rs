//! A hand exoskeleton with force on the tips of index and thumb, and a tactile array on each (Fontana et al. 2013, Salsedo et
//! al. 2011, as in Tripicchio, D'Avella and Ruffaldi 2022), over UDP.
//!
//! The published descriptions give 5 x 6 pins of at most 73 mN, 2.4 mm across; pitch, forces, stiffness and workspace are not
//! in them, so they are parameters, and their defaults are assumptions. Tested against a twin, never on hardware.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod key;
pub mod link;
mod params;
pub mod receiver;
pub mod wire;

use core::ffi::CStr;
use key::Key;
use link::{Link, Say};
use params::{PARAMS, Settings};
use pliant_plugin_api::abi::{DeviceInfo, Output, POSE_VALID, POSE_VELOCITY, Pose};
use pliant_plugin_api::{AsDevice, Device, Fault, Finding, Info, Params, export_plugins};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use wire::{EFFECTORS, Feel};

/// An exoskeleton that has answered.
pub struct Exoskeleton {
    link: Link,
    facts: DeviceInfo,
    /// ns, silence after which it is lost
    patience: u64,
    /// N, as bits, what was last sent to each fingertip, and until when on the host's clock, ns.
    force: [[AtomicU64; 3]; EFFECTORS],
    until: AtomicU64,
    /// Outputs that were not finite, and those over a limit.
    refused: AtomicU64,
    clamped: AtomicU64,
    /// Reads at which the last pose had expired.
    poseless: AtomicU64,
}

impl Exoskeleton {
    /// The conversation.
    pub fn link(&self) -> &Link {
        &self.link
    }

    fn keep(&self, feels: &[Feel; EFFECTORS], until: u64) {
        for (kept, feel) in self.force.iter().zip(feels) {
            kept.iter().zip(feel.force).for_each(|(to, f)| to.store(f.to_bits(), Ordering::Relaxed));
        }
        self.until.store(until, Ordering::Relaxed);
    }

    /// What of an output this device may be told.
    fn limit(&self, output: &Output) -> Feel {
        let mut feel = Feel::default();
        let size = output.force.iter().map(|f| f * f).sum::<f64>().sqrt();
        if !output.force.iter().all(|f| f.is_finite()) {
            self.refused.fetch_add(1, Ordering::Relaxed);
        } else if size > self.facts.peak_force {
            self.clamped.fetch_add(1, Ordering::Relaxed);
            let scale = if size.is_finite() { self.facts.peak_force / size } else { 0.0 };
            feel.force = output.force.map(|f| f * scale);
        } else {
            feel.force = output.force;
        }
        let most = self.facts.taxel_force;
        for (to, wanted) in feel.taxels.iter_mut().zip(self.taxels(output)) {
            // A comparison with a value that is no number is false.
            *to = if *wanted > 0.0 { wanted.min(most) as f32 } else { 0.0 };
        }
        feel
    }

    #[allow(unsafe_code, reason = "reads the array whose length the host takes from `describe`")]
    fn taxels<'a>(&self, output: &'a Output) -> &'a [f64] {
        if output.taxels.is_null() {
            return &[];
        }
        // SAFETY: rows x columns doubles, as described, borrowed for the call of `write`.
        unsafe {
            core::slice::from_raw_parts(output.taxels, (self.facts.taxel_rows * self.facts.taxel_columns) as usize)
        }
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
        let link = Link::new(settings.peer, settings.layout, key).map_err(|e| Fault::io(e.to_string()))?;
        link.meet(Duration::from_secs_f64(settings.patience))
            .map_err(|e| Fault::io(format!("{e}; {}", params::REMEDY)))?;
        Ok(Self {
            link,
            facts: settings.facts,
            patience: (settings.lost_after * 1e9) as u64,
            force: Default::default(),
            until: AtomicU64::new(0),
            refused: AtomicU64::new(0),
            clamped: AtomicU64::new(0),
            poseless: AtomicU64::new(0),
        })
    }

    fn describe(&self) -> DeviceInfo {
        self.facts
    }

    fn read(&self, time: u64, poses: &mut [Pose]) -> Result<(), Fault> {
        let news = self.link.hear();
        if news.age > self.patience {
            return Err(Fault::io("the exoskeleton has fallen silent"));
        }
        self.poseless.fetch_add(u64::from(!news.holds), Ordering::Relaxed);
        for (pose, finger) in poses.iter_mut().zip(&news.fingers) {
            let sensed = news.holds && finger.flags & 1 != 0;
            let velocity = if finger.flags & 2 != 0 { POSE_VELOCITY } else { 0 };
            *pose = Pose {
                time_ns: time.saturating_sub(news.age),
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
        let mut feels = [Feel::default(); EFFECTORS];
        let mut until = u64::MAX;
        for (feel, output) in feels.iter_mut().zip(outputs) {
            *feel = self.limit(output);
            until = until.min(output.valid_until_ns);
        }
        self.keep(&feels, until);
        self.link.send(&feels, until.saturating_sub(time), Say::Feel);
        Ok(())
    }

    fn stop(&self) {
        self.keep(&[Feel::default(); EFFECTORS], 0);
        // Thrice: one may get lost, and a stop is worth it.
        (0..3).for_each(|_| self.link.send(&[Feel::default(); EFFECTORS], 0, Say::Stop));
    }

    fn rendered(&self, time: u64, outputs: &mut [Output]) -> Result<(), Fault> {
        let holds = time < self.until.load(Ordering::Relaxed);
        for (output, kept) in outputs.iter_mut().zip(&self.force) {
            for (to, from) in output.force.iter_mut().zip(kept) {
                *to = if holds { f64::from_bits(from.load(Ordering::Relaxed)) } else { 0.0 };
            }
        }
        Ok(())
    }

    fn counter(&self, index: u32) -> Option<(&'static CStr, u64)> {
        let c = self.link.counts();
        let all = [
            (c"poses taken", c.taken),
            (c"poses late", c.late),
            (c"poses duplicate", c.duplicate),
            (c"poses lost", c.lost),
            (c"poses stale", c.stale),
            (c"datagrams malformed", c.malformed),
            (c"datagrams unauthentic", c.unauthentic),
            (c"datagrams foreign", c.foreign),
            (c"reads without a pose", self.poseless.load(Ordering::Relaxed)),
            (c"commands sent", self.link.sent()),
            (c"commands unsent", self.link.unsent()),
            (c"forces refused", self.refused.load(Ordering::Relaxed)),
            (c"forces clamped", self.clamped.load(Ordering::Relaxed)),
        ];
        all.get(index as usize).copied()
    }

    fn probe(params: &Params<'_>) -> Vec<Finding> {
        params::probe(params)
    }
}

impl Drop for Exoskeleton {
    fn drop(&mut self) {
        (0..3).for_each(|_| self.link.send(&[Feel::default(); EFFECTORS], 0, Say::Goodbye));
    }
}

export_plugins!(AsDevice<Exoskeleton>);
