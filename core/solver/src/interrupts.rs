//! Interruption of a step: a cancel token and a deadline.
//!
//! They are checked once in each substep, Newton iteration and iteration of a linear solver, and in no loop over nodes or elements. An
//! interrupted step is rolled back: the body keeps its state before the step.

use crate::integrate::StepError;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A thread-safe flag; once it is set, steps that hold a clone stop at their next check.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl From<Arc<AtomicBool>> for CancelToken {
    /// A token that shares `flag`: it is cancelled while `flag` is true.
    fn from(flag: Arc<AtomicBool>) -> Self {
        Self(flag)
    }
}

impl CancelToken {
    /// Sets the flag: work stops at its next check.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the flag is set.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Conditions under which a step is interrupted. By default there are none.
#[derive(Clone, Debug, Default)]
pub struct Interrupts {
    /// Interrupts this and all later steps when it is cancelled.
    pub cancel: CancelToken,
    /// Time after which a step is interrupted at its next check; `None` for no limit.
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
    pub fn is_interrupted(&self) -> bool {
        self.check().is_err()
    }
}
