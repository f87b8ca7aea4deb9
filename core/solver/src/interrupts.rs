//! What ends a step before its time: somebody who stops the work, and a deadline.
//!
//! Substeps, Newton iterations and iterations of linear solvers look once each; no loop over nodes or elements does. A step that is ended so
//! is taken back: the body is where it was before the step.

use crate::integrate::StepError;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A flag that stops work, shared by whoever sets it and whoever looks.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// A token that is cancelled when `flag` becomes true.
    pub fn of(flag: Arc<AtomicBool>) -> Self {
        Self(flag)
    }

    /// Stops the work.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the work is to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Why a step may be ended before it is done. By default nothing ends one.
#[derive(Clone, Debug, Default)]
pub struct Interrupts {
    /// Stops every step from now on.
    pub cancel: CancelToken,
    /// When a step has taken too long; `None` for never.
    pub deadline: Option<Instant>,
}

impl Interrupts {
    /// # Errors
    /// [`StepError::Cancelled`] or [`StepError::TimedOut`], if the step is to end.
    pub fn check(&self) -> Result<(), StepError> {
        if self.cancel.is_cancelled() {
            return Err(StepError::Cancelled);
        }
        match self.deadline {
            Some(deadline) if Instant::now() > deadline => Err(StepError::TimedOut),
            _ => Ok(()),
        }
    }

    /// Whether the step is to end.
    pub fn is_due(&self) -> bool {
        self.check().is_err()
    }
}
