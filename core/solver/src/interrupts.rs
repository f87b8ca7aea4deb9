//! Interruption of a step: a cancel token and a deadline.
//!
//! They are checked once in each substep, Newton iteration and iteration of a linear solver, and in no loop over nodes or elements. An
//! interrupted step is undone: the body keeps its state before the step.

use crate::integrate::StepError;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A shared flag that stops work.
#[derive(Clone, Default)]
pub struct CancelToken {
    flag: Arc<AtomicBool>,
    /// Asked too, where there is one.
    poll: Option<Arc<dyn Fn() -> bool + Send + Sync>>,
}

impl CancelToken {
    /// A token that is cancelled when `flag` becomes true.
    pub fn of(flag: Arc<AtomicBool>) -> Self {
        Self { flag, poll: None }
    }

    /// A token that is cancelled while `poll` returns true. It is called at each check, on the thread that steps, so it must be quick.
    pub fn polled(poll: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self { flag: Arc::default(), poll: Some(Arc::new(poll)) }
    }

    /// Sets the flag: work stops at its next check.
    pub fn cancel(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// Whether the flag is set, or the poll says so.
    pub fn is_cancelled(&self) -> bool {
        self.flag.load(Ordering::Relaxed) || self.poll.as_ref().is_some_and(|poll| poll())
    }
}

impl fmt::Debug for CancelToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "CancelToken({})", self.flag.load(Ordering::Relaxed))
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
