//! Snapshots between the haptic thread and the simulation, through triple buffers: only the newest is read, and neither side waits.

use pliant_engine::session::Session;
use pliant_engine::tool::ContactModel;
use pliant_host::Pose;
use pliant_plugin_api::abi::Status;
use pliant_solver::Vec3;
use triple_buffer::{Input, Output};

/// Cause of the loss of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceLoss {
    /// The call that failed: `read` or `write`.
    pub call: &'static str,
    /// Status it returned.
    pub status: Status,
}

/// Snapshot from the haptic thread: poses of the hands and forces on them.
#[derive(Clone, Debug, Default)]
pub struct HandSamples {
    /// Time at which the poses were read, ns.
    pub time: u64,
    /// Poses of each effector of each device, in the order of the session's devices.
    pub poses: Vec<Vec<Pose>>,
    /// Last force rendered to each tool's effector, in axes of its device, N (tools x 3).
    pub device_forces: Vec<Vec3>,
    /// Cause of the loss of each device; `None` if it is not lost.
    pub losses: Vec<Option<DeviceLoss>>,
}

/// Snapshot from the simulation, in the order of the tools.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactModels {
    /// Contact of each tool, from which forces are rendered until the next snapshot.
    pub(crate) contacts: Vec<ContactModel>,
    /// Torque on each tool's hand, N m, in axes of the scene (tools x 3).
    pub(crate) torques: Vec<Vec3>,
    /// Force of each pin of each tool's tactile array, N (rows x columns); empty without an array.
    pub(crate) taxels: Vec<Vec<f64>>,
}

/// The simulation's end of the buffers between it and the haptic thread.
pub struct SimulationPort {
    pub(crate) samples: Output<HandSamples>,
    pub(crate) models: Input<ContactModels>,
    /// Time of the poses of the last step, ns.
    last_time: Option<u64>,
}

impl SimulationPort {
    /// A port with the simulation's ends of both buffers.
    pub(crate) fn new(samples: Output<HandSamples>, models: Input<ContactModels>) -> Self {
        Self { samples, models, last_time: None }
    }

    /// Takes a step of the session with the newest poses and publishes its contacts. Returns the snapshot it used. `prepare` is called once they are read.
    /// A step that is cancelled publishes nothing.
    pub fn step(&mut self, session: &mut Session, prepare: impl FnOnce(&mut Session)) -> &HandSamples {
        let samples = self.samples.read();
        prepare(session);
        session.step_with(&samples.poses);
        if session.is_cancelled() {
            return samples;
        }
        let models = self.models.input_buffer_mut();
        session.contact_models(samples.time, &mut models.contacts);
        // If the simulation is slower than real time, drift velocities are converted from simulated to wall-clock time.
        let elapsed = self.last_time.replace(samples.time).map_or(0, |before| samples.time.saturating_sub(before));
        let pace = if elapsed > 0 { (session.dt() / (elapsed as f64 * 1e-9)).min(1.0) } else { 0.0 };
        for contact in &mut models.contacts {
            contact.drift = pace * contact.drift;
        }
        for (to, felt) in models.torques.iter_mut().zip(&session.frame().tools) {
            *to = felt.torque;
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

    /// Publishes contact models that do not come from a session.
    pub fn publish(&mut self, contacts: &[ContactModel]) {
        self.models.input_buffer_mut().contacts.copy_from_slice(contacts);
        self.models.publish();
    }

    /// The newest snapshot of the hands.
    pub fn latest(&mut self) -> &HandSamples {
        self.samples.read()
    }
}
