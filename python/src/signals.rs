//! Ctrl-C within a step: Python's signal handlers run while a step is under way, and what they raise ends it.

use super::law::check_signals;
use pliant_engine::session::{CancelToken, Session};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Time between two calls of the signal handlers, for which the interpreter's lock is taken.
pub const SIGNAL_PERIOD: Duration = Duration::from_millis(20);

/// What signal handlers raised during the steps of a session.
pub struct Signals(Mutex<State>);

struct State {
    checked: Instant,
    raised: Option<PyErr>,
}

impl Signals {
    /// From now on what signal handlers raise ends the step of the session that is under way, if the main thread takes it.
    pub fn watch(session: &mut Session) -> Arc<Self> {
        let signals = Arc::new(Self(Mutex::new(State { checked: Instant::now(), raised: None })));
        let watched = Arc::clone(&signals);
        session.cancel_when(CancelToken::polled(move || watched.poll()));
        signals
    }

    /// Whether something was raised. Calls the handlers when they are due.
    fn poll(&self) -> bool {
        let mut state = self.state();
        if state.raised.is_none() && state.checked.elapsed() >= SIGNAL_PERIOD {
            state.raised = Python::attach(|py| check_signals(py).err());
            state.checked = Instant::now();
        }
        state.raised.is_some()
    }

    /// Raises what was raised since the last call.
    pub fn check(&self, py: Python<'_>) -> PyResult<()> {
        match self.state().raised.take() {
            Some(raised) => Err(raised),
            None => check_signals(py),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
