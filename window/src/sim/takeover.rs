//! A simulation that goes on until another one takes its device over, so that the device is not closed when a model is opened anew.

use super::Simulation;
use super::messages::Command;
use pliant_editor::DeviceHand;
use pliant_engine::session::{Session, TouchingProxy};
use pliant_live::{LiveSession, PointerHandle, ViewWriter};
use std::sync::{Arc, Mutex, PoisonError};

/// The live session of a simulation that has ended, and where its tools touch.
pub(super) struct HandedOver {
    pub(super) live: LiveSession,
    pub(super) touching: Vec<TouchingProxy>,
}

/// Where a simulation leaves its live session.
pub(super) type Handover = Arc<Mutex<Option<HandedOver>>>;

/// The simulation that has the device until now, and the hand that it and the pointer move.
pub struct Predecessor {
    /// It goes on meanwhile.
    pub simulation: Simulation,
    /// The hand of the pointer.
    pub hand: PointerHandle,
    /// The hand of the device.
    pub device_hand: DeviceHand,
}

/// What a simulation has of its predecessor.
pub(super) struct TakenOver {
    pub(super) live: LiveSession,
    pub(super) hand: PointerHandle,
    pub(super) device_hand: DeviceHand,
}

impl Predecessor {
    /// Ends the simulation and gives its device to the hand of a session; `None` where that cannot have it: the device is closed then.
    pub(super) fn hand_over(mut self, session: &mut Session, view: Option<ViewWriter>) -> Option<TakenOver> {
        let HandedOver { live, touching } = self.simulation.hand_over()?;
        let rescaling = self.device_hand.continue_in(session, 0);
        let mut rescalings = vec![None; session.devices.len()];
        rescalings[session.tools[0].device] = Some(rescaling);
        let live = live.hand_over(session, &touching, &rescalings, view).ok()?;
        Some(TakenOver { live, hand: self.hand, device_hand: self.device_hand })
    }
}

impl Simulation {
    /// Ends the simulation between two steps and gives its live session, whose haptic thread goes on; `None` where it has ended by itself.
    fn hand_over(&mut self) -> Option<HandedOver> {
        self.send(Command::HandOver);
        if let Some(thread) = self.thread.take() {
            // One that has panicked has left nothing.
            let _ = thread.join();
        }
        self.handover.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}
