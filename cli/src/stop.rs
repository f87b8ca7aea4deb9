//! Ctrl-C and requests to terminate: the first shuts down cleanly, the second ends the program at once.

use crate::outcome::Outcome;
use crate::output::note;
use pliant_engine::session::{CancelToken, Session};
use pliant_host::{end_at_once, plugin_calls};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that the first Ctrl-C sets; the second stops the devices and ends the program. If the handler cannot be installed, the
/// first ends the program. Result files are never left incomplete: they are written under temporary names and renamed.
pub fn stop_flag() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let handler = Arc::clone(&stop);
    let _ = ctrlc::set_handler(move || {
        if handler.swap(true, Ordering::Relaxed) {
            end_stopped();
        }
        note("stopping; press Ctrl-C again to end at once");
    });
    stop
}

/// Ctrl-C handling of one run: the first Ctrl-C cancels the current step, or ends the program if the scene is still being opened; the second
/// ends the program at once.
pub struct RunStop {
    flag: Arc<AtomicBool>,
    /// Whether a session is open, so a stop can cancel its step.
    session_open: Arc<AtomicBool>,
}

impl RunStop {
    /// Installs the handler.
    pub fn new() -> Self {
        let (flag, session_open) = (Arc::<AtomicBool>::default(), Arc::<AtomicBool>::default());
        let (handler_flag, handler_open) = (Arc::clone(&flag), Arc::clone(&session_open));
        let _ = ctrlc::set_handler(move || {
            if handler_flag.swap(true, Ordering::Relaxed) || !handler_open.load(Ordering::Relaxed) {
                end_stopped();
            }
            note("stopping; press Ctrl-C again to end at once");
        });
        Self { flag, session_open }
    }

    /// Attaches an opened session: from now on a stop cancels its current step.
    pub fn attach(&self, session: &mut Session) {
        session.cancel_when(CancelToken::from(Arc::clone(&self.flag)));
        self.session_open.store(true, Ordering::Relaxed);
    }

    /// Whether a stop was requested.
    pub fn is_set(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }
}

/// The first Ctrl-C stops the devices and ends the program: for commands that write no files.
pub fn end_on_stop() {
    let _ = ctrlc::set_handler(|| end_stopped());
}

/// Ends the program at once and prints the plugin calls in progress.
fn end_stopped() -> ! {
    for call in plugin_calls() {
        note(&format!("interrupted while in {call}"));
    }
    end_at_once(Outcome::Stopped.exit_code())
}
