//! Interruption of a step: a cancel token and a deadline.
//!
//! They are checked once in each substep, Newton iteration and iteration of a linear solver, and in no loop over nodes or elements. An
//! interrupted step is undone: the body keeps its state before the step.

use crate::integrate::StepError;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A shared flag that stops work.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// A token that is cancelled when `flag` becomes true.
    pub fn of(flag: Arc<AtomicBool>) -> Self {
        Self(flag)
    }

    /// Sets the flag: work stops at its next check.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the flag is set.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Conditions on which a step is interrupted. By default there are none.
#[derive(Clone, Debug, Default)]
pub struct Interrupts {
    /// Interrupts this and all later steps when it is cancelled.
    pub cancel: CancelToken,
    /// Time at which a step is interrupted; `None` for no limit.
    pub deadline: Option<Instant>,
}

impl Interrupts {
    /// Checks the conditions.
    ///
    /// # Errors
    /// [`StepError::Cancelled`] or [`StepError::TimedOut`] if the step must be interrupted.
    pub fn check(&self) -> Result<(), StepError> {
        if self.cancel.is_cancelled() {
            return Err(StepError::Cancelled);
        }
        match self.deadline {
            Some(deadline) if Instant::now() > deadline => Err(StepError::TimedOut),
            _ => Ok(()),
        }
    }

    /// Whether the step must be interrupted.
    pub fn is_due(&self) -> bool {
        self.check().is_err()
    }
}
