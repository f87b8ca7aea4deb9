//! Undo and redo: shape, motion and cuts together.
//!
//! What is kept of a body is as large as what is active and what was cut; the surface is shared until it changes.

use super::{EventKind, Session};
use crate::body::BodyState;
use crate::plan::Edit;
use crate::scene::Release;

/// Edits that can be taken back and made again.
#[derive(Default)]
pub(super) struct History {
    pub(super) kept: bool,
    /// Tools with such an edit under way, and all bodies before it.
    under_way: Vec<(usize, Vec<BodyState>)>,
    done: Vec<Vec<BodyState>>,
    undone: Vec<Vec<BodyState>>,
}

/// Edits that can be taken back.
const MOST: usize = 100;

/// Whether an edit is one that can be taken back.
fn is_remembered(edit: &Edit) -> bool {
    edit.kind.cuts() || edit.release == Release::Keep
}

impl Session {
    /// Keeps from now on what is needed for [`Session::undo`].
    pub fn keep_history(&mut self) {
        self.history.kept = true;
    }

    /// Edits that can be taken back, and that can be made again.
    pub fn history(&self) -> (usize, usize) {
        (self.history.done.len() + self.history.under_way.len(), self.history.undone.len())
    }

    /// Takes everything back to where it was when the last cut, or the last edit whose shape was kept, began; one that is
    /// under way ends first, and does not begin again before its button is pressed anew. Gives whether there was one.
    pub fn undo(&mut self) -> bool {
        if self.history().0 == 0 {
            return false;
        }
        self.end_edits();
        let Some(before) = self.history.done.pop() else { return false };
        let now = self.save();
        self.history.undone.push(now);
        self.restore(&before);
        true
    }

    /// Makes again what was taken back last. Gives whether there was anything.
    pub fn redo(&mut self) -> bool {
        if self.history.undone.is_empty() {
            return false;
        }
        self.end_edits();
        let Some(after) = self.history.undone.pop() else { return false };
        let now = self.save();
        self.history.done.push(now);
        self.restore(&after);
        true
    }

    /// An edit begins with a tool.
    pub(super) fn remember(&mut self, tool: usize, edit: usize) {
        if self.history.kept && is_remembered(&self.plan.edits[edit]) {
            let now = self.save();
            self.history.under_way.push((tool, now));
            self.history.undone.clear();
        }
    }

    /// The edit of a tool is over; `changed` tells whether there is anything to take back.
    pub(super) fn settle(&mut self, tool: usize, changed: bool) {
        let Some(place) = self.history.under_way.iter().position(|(t, _)| *t == tool) else { return };
        let (_, before) = self.history.under_way.remove(place);
        if changed {
            self.history.done.push(before);
            let over = self.history.done.len().saturating_sub(MOST);
            self.history.done.drain(..over);
        }
    }

    fn end_edits(&mut self) {
        for tool in 0..self.tools.len() {
            let Some(edit) = self.tools[tool].edit else { continue };
            self.end_edit(tool);
            self.tools[tool].taken_back = Some(edit).filter(|edit| is_remembered(&self.plan.edits[*edit]));
        }
    }

    fn save(&self) -> Vec<BodyState> {
        self.bodies.iter().map(crate::body::Body::save).collect()
    }

    fn restore(&mut self, states: &[BodyState]) {
        let time = self.time();
        for (index, state) in states.iter().enumerate() {
            match self.bodies[index].restore(state) {
                Ok(()) => self.changed(index),
                Err(error) => self.freeze(index, time, error.to_string()),
            }
        }
        for slot in &mut self.tools {
            slot.tool.release(&slot.hand);
        }
        self.events.add(EventKind::History, time, || format!("at {time} s"));
    }
}
