//! Commands that a scene takes from its recordings, together with hands.

use super::{Session, SessionCommand};
use std::sync::Arc;

impl Session {
    /// Commands that the session's recordings gave it before the last step. A recording of this session has them before that step.
    pub fn recorded_commands(&self) -> impl Iterator<Item = &SessionCommand> {
        let last = self.clock.steps.checked_sub(1);
        last.into_iter().flat_map(|last| self.inputs.recordings.iter().flat_map(move |hands| hands.commands(last)))
    }

    /// Whether edits can be undone.
    pub fn keeps_history(&self) -> bool {
        self.editing.history.kept
    }

    /// Applies the commands that recordings have before the step that is about to be taken.
    pub(super) fn apply_recorded(&mut self) {
        let step = self.clock.steps;
        for at in 0..self.inputs.recordings.len() {
            let recording = Arc::clone(&self.inputs.recordings[at]);
            for command in recording.commands(step) {
                self.apply(command.clone());
            }
        }
    }
}
