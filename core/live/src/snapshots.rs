//! Whole snapshots between the haptic thread and the simulation, through triple buffers: the newest wins, neither side waits.

use pliant_engine::session::Session;
use pliant_engine::tool::ContactModel;
use pliant_host::Pose;
use pliant_plugin_api::abi::Status;
use pliant_solver::Vec3;
use triple_buffer::{Input, Output};

/// Why a device was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceLoss {
    /// The call that failed: `read` or `write`.
    pub call: &'static str,
    /// Status it gave.
    pub status: Status,
}

/// Snapshot from the haptic thread: poses of the hands and forces on them.
#[derive(Clone, Debug, Default)]
pub struct HandSamples {
    /// ns, time the poses were read
    pub time: u64,
    /// Poses of each effector of each device, in the order of the session's devices.
    pub poses: Vec<Vec<Pose>>,
    /// N (tools x 3), force last given to each tool's effector, in the axes of its device
    pub device_forces: Vec<Vec3>,
    /// Why each device was lost; `None` where it was not.
    pub losses: Vec<Option<DeviceLoss>>,
}

/// Snapshot from the simulation, in the order of the tools.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactModels {
    /// Contact of each tool, from which forces are rendered until the next snapshot.
    pub(crate) contacts: Vec<ContactModel>,
    /// N (rows x columns), force of each pin of each tool's tactile array; empty without one
    pub(crate) taxels: Vec<Vec<f64>>,
}

/// The simulation's end of the buffers between it and the haptic thread.
pub struct SimulationPort {
    pub(crate) samples: Output<HandSamples>,
    pub(crate) models: Input<ContactModels>,
    /// ns, time of the poses of the last step
    last_time: Option<u64>,
}

impl SimulationPort {
    /// The ends of both buffers that are the simulation's.
    pub(crate) fn new(samples: Output<HandSamples>, models: Input<ContactModels>) -> Self {
        Self { samples, models, last_time: None }
    }

    /// Takes a step of the session with the newest poses and publishes its contacts. Returns the snapshot it used.
    pub fn step(&mut self, session: &mut Session) -> &HandSamples {
        let samples = self.samples.read();
        session.step_with(&samples.poses);
        let models = self.models.input_buffer_mut();
        session.contact_models(samples.time, &mut models.contacts);
        // Where the simulation is slower than real time its contacts move slower for the hand: drift per simulated second becomes drift per
        // second.
        let elapsed = self.last_time.replace(samples.time).map_or(0, |before| samples.time.saturating_sub(before));
        let pace = if elapsed > 0 { (session.dt() / (elapsed as f64 * 1e-9)).min(1.0) } else { 0.0 };
        for contact in &mut models.contacts {
            contact.drift = pace * contact.drift;
        }
        for (to, slot) in models.taxels.iter_mut().zip(&session.tools) {
            if let Some(pad) = &slot.pad {
                to.copy_from_slice(&pad.taxels);
            }
        }
        self.models.publish();
        session.report_device_forces(&samples.device_forces);
        samples
    }

    /// Publishes contacts that come from elsewhere than a session.
    pub fn publish(&mut self, contacts: &[ContactModel]) {
        self.models.input_buffer_mut().contacts.copy_from_slice(contacts);
        self.models.publish();
    }

    /// The newest snapshot of the hands.
    pub fn latest(&mut self) -> &HandSamples {
        self.samples.read()
    }
}
