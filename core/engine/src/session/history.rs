//! Undo, redo and snapshots: shape, motion and cuts together.
//!
//! What is kept of a body is as large as what is active and what was cut; the surface is shared until it changes.

use super::{EventKind, Session};
use crate::body::BodyState;
use crate::plan::{Edit, Trigger};
use crate::scene::Release;
use pliant_plugin_api::abi;
use thiserror::Error;

/// Edits that can be taken back and made again.
#[derive(Default)]
pub(super) struct History {
    pub(super) kept: bool,
    /// Tools with such an edit under way, and all bodies before it.
    under_way: Vec<(usize, Vec<BodyState>)>,
    done: Vec<Vec<BodyState>>,
    undone: Vec<Vec<BodyState>>,
}

/// All bodies of a session at one moment, and its time.
pub struct Snapshot {
    bodies: Vec<BodyState>,
    steps: u64,
    clock: HistoryClock,
    cut_branches: u64,
    cuts: super::CutCounts,
    is_cut: bool,
}

/// Why a session cannot go back to a snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum SnapshotError {
    /// Its bodies are not those of the session.
    #[error("the snapshot has {found} bodies and the session {expected}; allowed is a snapshot of the same session")]
    Bodies {
        /// Bodies of the snapshot.
        found: usize,
        /// Bodies of the session.
        expected: usize,
    },
    /// What was cut when it was taken was taken back, and something else cut since.
    #[error(
        "something else was cut since the snapshot's own cuts were taken back; allowed is a snapshot without cuts, or one of the present cuts"
    )]
    Recut,
}

/// What the undos and redos of a scene have seen so far.
#[derive(Clone, Copy, Default)]
pub(super) struct HistoryClock {
    /// s, the end of the time in which those of a time have happened
    until: Option<f64>,
    /// Buttons that were down in the last step, of all hands together.
    buttons: u32,
}

/// Edits that can be taken back.
const MOST: usize = 100;

impl Session {
    /// Keeps from now on what is needed for [`Session::undo`].
    pub fn keep_history(&mut self) {
        self.history.kept = true;
    }

    /// Edits that can be taken back, and that can be made again.
    pub fn history(&self) -> (usize, usize) {
        (self.history.done.len() + self.history.under_way.len(), self.history.undone.len())
    }

    /// Takes everything back to where it was when the last cut, or the last edit that left another shape or history, began; one that is
    /// under way ends first, and does not begin again before its button is pressed anew. Gives whether there was one.
    pub fn undo(&mut self) -> bool {
        if self.history().0 == 0 {
            return false;
        }
        self.end_edits();
        let Some(before) = self.history.done.pop() else { return false };
        let now = self.save();
        self.history.undone.push(now);
        self.restore_bodies(&before);
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
        self.restore_bodies(&after);
        true
    }

    /// All bodies as they are now, with the time; for [`Session::go_back`]. What tools hold is not kept.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            bodies: self.save(),
            steps: self.steps,
            clock: self.clock,
            cut_branches: self.cut_branches,
            cuts: self.cuts.clone(),
            is_cut: self.bodies.iter().any(|body| body.cut.as_ref().is_some_and(|mesh| mesh.depth() > 0)),
        }
    }

    /// Goes back, or forward, to a snapshot of this session. Tools let go of what they hold and take it up again in the next step; edits
    /// before can no longer be taken back.
    ///
    /// # Errors
    /// A snapshot of another session, or of cuts that no longer exist.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let (found, expected) = (snapshot.bodies.len(), self.bodies.len());
        if found != expected {
            return Err(SnapshotError::Bodies { found, expected });
        }
        if snapshot.is_cut && snapshot.cut_branches != self.cut_branches {
            return Err(SnapshotError::Recut);
        }
        // An edit that ended properly could cut once more or keep its shape; what it did is given up.
        for slot in &mut self.tools {
            (slot.edit, slot.taken_back, slot.advances) = (None, None, 0);
            slot.tool.set_action(None);
        }
        self.history = History { kept: self.history.kept, ..History::default() };
        self.restore_bodies(&snapshot.bodies);
        (self.steps, self.clock) = (snapshot.steps, snapshot.clock);
        self.cuts = snapshot.cuts.clone();
        self.frame.time = self.time();
        Ok(())
    }

    /// The scene's undos (false) and redos (true) that are due at `time` (s): those of a time by their time, then those of a button that a
    /// hand has pressed since the last step.
    pub(super) fn due_history_steps(&mut self, time: f64) -> Vec<bool> {
        let hands = self.tools.iter().filter(|slot| slot.hand.present);
        let buttons = hands.fold(0, |down, slot| down | slot.hand.buttons);
        let pressed = buttons & !self.clock.buttons;
        let after = self.clock.until.unwrap_or(f64::NEG_INFINITY);
        (self.clock.buttons, self.clock.until) = (buttons, Some(time));
        let mut timed = Vec::new();
        let mut by_button = Vec::new();
        for step in &self.plan.history_steps {
            match step.trigger {
                Trigger::Time(at) if after < at && at <= time => timed.push((at, step.redo)),
                Trigger::Button { button, span } if span.0 <= time && time < span.1 && pressed >> button & 1 == 1 => {
                    by_button.push(step.redo);
                }
                Trigger::Time(_) | Trigger::Button { .. } => {}
            }
        }
        timed.sort_by(|a, b| a.0.total_cmp(&b.0));
        timed.into_iter().map(|(_, redo)| redo).chain(by_button).collect()
    }

    /// Whether an edit is one that can be taken back. Where a material has a history, as clay has, any edit may leave something.
    fn is_remembered(&self, edit: &Edit) -> bool {
        let leaves = edit.kind.cuts() || edit.kind.changes_rest_shape() || edit.release == Release::Keep;
        leaves || self.bodies.iter().any(|body| body.system.sets.iter().any(|set| set.has(abi::HAS_HISTORY)))
    }

    /// An edit begins with a tool.
    pub(super) fn remember(&mut self, tool: usize, edit: usize) {
        if self.history.kept && self.is_remembered(&self.plan.edits[edit]) {
            if self.tools[tool].mirror.is_some() {
                return; // a part of the stroke of the hand it mirrors
            }
            let now = self.save();
            self.history.under_way.push((tool, now));
            self.history.undone.clear();
        }
    }

    /// The edit of a tool is over; `changed` tells whether there is anything to take back.
    pub(super) fn settle(&mut self, tool: usize, changed: bool) {
        let Some(place) = self.history.under_way.iter().position(|(t, _)| *t == tool) else { return };
        let (_, before) = self.history.under_way.remove(place);
        let has_flowed = || self.bodies.iter().zip(&before).any(|(body, before)| before.has_other_history(body));
        if changed || has_flowed() {
            self.history.done.push(before);
            let over = self.history.done.len().saturating_sub(MOST);
            self.history.done.drain(..over);
        }
    }

    fn end_edits(&mut self) {
        for tool in 0..self.tools.len() {
            let Some(edit) = self.tools[tool].edit else { continue };
            self.end_edit(tool);
            self.tools[tool].taken_back = Some(edit).filter(|edit| self.is_remembered(&self.plan.edits[*edit]));
        }
    }

    fn save(&self) -> Vec<BodyState> {
        self.bodies.iter().map(crate::body::Body::save).collect()
    }

    fn restore_bodies(&mut self, states: &[BodyState]) {
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
