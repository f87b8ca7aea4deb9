//! Messages and errors that the window shows.

use super::App;
use std::time::{Duration, Instant};

/// Time in which a message that comes again is the same one: a stroke that is refused is so in many of its steps.
const SAME_MESSAGE: Duration = Duration::from_secs(5);

impl App {
    /// Shows a message for a while. One that is shown already is shown longer.
    pub(super) fn tell(&mut self, text: String) {
        match self.messages.last_mut() {
            Some((when, last)) if *last == text && when.elapsed() < SAME_MESSAGE => *when = Instant::now(),
            _ => self.messages.push((Instant::now(), text)),
        }
    }

    /// Shows an error until it is closed.
    pub(super) fn fail(&mut self, text: String) {
        self.log.event("failed", &[("text", text.clone())]);
        self.error = Some(text);
    }
}
