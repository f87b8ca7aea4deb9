//! The way from a simulation to a haptic thread that goes on: what the servo has of a session is exchanged for that of another one between two ticks.
//!
//! *Real time*: the haptic thread never waits: as long as the simulation has the exchange, it ticks with the session it has. It frees nothing: what it had is left
//! for the simulation.

use crate::servo_session::ServoSession;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// An exchange between a simulation and a haptic thread.
#[derive(Default)]
pub(crate) struct Handover {
    is_offered: AtomicBool,
    /// The session that is offered, then the one that was exchanged for it.
    slot: Mutex<Option<Box<ServoSession>>>,
}

impl Handover {
    /// Offers a session to the haptic thread.
    pub(crate) fn offer(&self, next: Box<ServoSession>) {
        *self.slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(next);
        self.is_offered.store(true, Ordering::Release);
    }

    /// Whether the haptic thread has not yet taken what was offered.
    pub(crate) fn is_offered(&self) -> bool {
        self.is_offered.load(Ordering::Acquire)
    }

    /// Takes back what is in the exchange: what was offered, or what the haptic thread had before.
    pub(crate) fn clear(&self) -> Option<Box<ServoSession>> {
        self.is_offered.store(false, Ordering::Release);
        self.slot.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Exchanges on the haptic thread, if something is offered and the simulation does not have the exchange now.
    pub(crate) fn take(&self, exchange: impl FnOnce(&mut Box<ServoSession>)) {
        if !self.is_offered() {
            return;
        }
        let Ok(mut slot) = self.slot.try_lock() else { return };
        if let Some(next) = &mut *slot {
            exchange(next);
            self.is_offered.store(false, Ordering::Release);
        }
    }
}
