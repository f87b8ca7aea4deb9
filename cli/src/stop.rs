//! Ctrl-C and requests to terminate: the first ends the work in good order, the second ends the program at once.

use crate::outcome::Outcome;
use crate::output::note;
use pliant_engine::session::{CancelToken, Session};
use pliant_host::{end_at_once, plugin_calls};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that the first Ctrl-C sets; the second stops the devices and ends the program. If the handler cannot be installed, the
/// first ends the program. No results are left in part either way: files are written under temporary names first.
pub fn stop_flag() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let handler = Arc::clone(&stop);
    let _ = ctrlc::set_handler(move || {
        if handler.swap(true, Ordering::Relaxed) {
            end_stopped();
        }
        note("stopping after this step; Ctrl-C again ends the program at once");
    });
    stop
}

/// The stop of a run: the first Ctrl-C cancels the step under way, or ends the program if the scene is still being opened; the second ends the program
/// at once.
pub struct RunStop {
    flag: Arc<AtomicBool>,
    /// Whether there is something to end in good order.
    has_begun: Arc<AtomicBool>,
}

impl RunStop {
    /// Installs the handler.
    pub fn new() -> Self {
        let (flag, has_begun) = (Arc::<AtomicBool>::default(), Arc::<AtomicBool>::default());
        let (handler_flag, handler_begun) = (Arc::clone(&flag), Arc::clone(&has_begun));
        let _ = ctrlc::set_handler(move || {
            if handler_flag.swap(true, Ordering::Relaxed) || !handler_begun.load(Ordering::Relaxed) {
                end_stopped();
            }
            note("stopping; Ctrl-C again ends the program at once");
        });
        Self { flag, has_begun }
    }

    /// From now on a stop cancels the current step of the session.
    pub fn begin(&self, session: &mut Session) {
        session.cancel_when(CancelToken::of(Arc::clone(&self.flag)));
        self.has_begun.store(true, Ordering::Relaxed);
    }

    /// Whether the run is to stop.
    pub fn is_set(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }
}

/// The first Ctrl-C stops the devices and ends the program: for work that leaves nothing behind.
pub fn end_on_stop() {
    let _ = ctrlc::set_handler(|| end_stopped());
}

/// Ends the program at once, saying which plugins it was in.
fn end_stopped() -> ! {
    for call in plugin_calls() {
        note(&format!("ended in {call}"));
    }
    end_at_once(Outcome::Stopped.exit_code())
}
