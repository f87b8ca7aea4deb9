//! What goes between the haptic thread and the simulation: whole snapshots, the newest wins, nobody waits.

use pliant_engine::session::Session;
use pliant_engine::tool::ContactModel;
use pliant_host::Pose;
use pliant_plugin_api::abi::Status;
use pliant_solver::V3;
use triple_buffer::{Input, Output};

/// From the hands.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// ns, when they were taken
    pub time: u64,
    /// Of each device, of each effector.
    pub poses: Vec<Vec<Pose>>,
    /// N, what each tool's effector was given last, in the axes of its device
    pub given: Vec<V3>,
    /// How each device was lost, if it was.
    pub lost: Vec<Option<(&'static str, Status)>>,
}

/// From the simulation, in the order of the tools.
#[derive(Clone, Debug, Default)]
pub struct Models {
    /// What each feels.
    pub contacts: Vec<ContactModel>,
    /// N, what each tactile array shows; empty where there is none
    pub taxels: Vec<Vec<f64>>,
}

/// The simulation's end.
pub struct Exchange {
    pub(super) samples: Output<Samples>,
    pub(super) models: Input<Models>,
    /// ns, the samples of the step before
    before: Option<u64>,
}

impl Exchange {
    pub(super) fn new(samples: Output<Samples>, models: Input<Models>) -> Self {
        Self { samples, models, before: None }
    }

    /// Takes a step under the newest hands and tells what it felt; gives those hands.
    pub fn step(&mut self, session: &mut Session) -> &Samples {
        let samples = self.samples.read();
        session.step_with(&samples.poses);
        let models = self.models.input_buffer_mut();
        session.contact_models(samples.time, &mut models.contacts);
        // A simulation that does not keep up has moved things in less time of its own than the hand had.
        let passed = self.before.replace(samples.time).map_or(0, |before| samples.time.saturating_sub(before));
        let pace = if passed > 0 { (session.dt() / (passed as f64 * 1e-9)).min(1.0) } else { 0.0 };
        for contact in &mut models.contacts {
            contact.drift = contact.drift.map(|v| pace * v);
        }
        for (to, slot) in models.taxels.iter_mut().zip(&session.tools) {
            if let Some(pad) = &slot.pad {
                to.copy_from_slice(&pad.taxels);
            }
        }
        self.models.publish();
        session.tell_given(&samples.given);
        samples
    }

    /// Tells contacts that no session has felt.
    pub fn tell(&mut self, contacts: &[ContactModel]) {
        self.models.input_buffer_mut().contacts.copy_from_slice(contacts);
        self.models.publish();
    }

    /// The newest hands.
    pub fn samples(&mut self) -> &Samples {
        self.samples.read()
    }
}
