//! Commands that a scene takes from its recordings, together with hands.

use super::{Session, SessionCommand};
use crate::recording::RecordedHands;
use std::sync::Arc;

/// Most commands that recordings have before one step.
pub(super) fn most_commands(recordings: &[Arc<RecordedHands>]) -> usize {
    recordings.iter().map(|recording| recording.most_commands()).sum()
}

impl Session {
    /// Commands that the session's recordings gave it before the last step. A recording of this session has them before that step.
    pub fn recorded_commands(&self) -> &[SessionCommand] {
        &self.commands
    }

    /// Whether edits can be undone.
    pub fn keeps_history(&self) -> bool {
        self.history.kept
    }

    /// Applies the commands that recordings have before the step that is about to be taken.
    pub(super) fn apply_recorded(&mut self) {
        self.commands.clear();
        for recording in &self.recordings {
            self.commands.extend_from_slice(recording.commands(self.clock.steps));
        }
        for place in 0..self.commands.len() {
            self.apply(self.commands[place].clone());
        }
    }
}
