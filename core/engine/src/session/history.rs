//! Undo, redo and snapshots of shape, motion and cuts.
//!
//! The size of a saved state is that of the active nodes and the cuts; the surface is shared until it changes.

use super::sculpt_layers::SculptLayers;
use super::ties::Ties;
use super::{CutCounts, EventKind, Session};
use crate::body::BodyState;
use crate::plan::{Edit, Trigger};
use crate::scene::Release;
use pliant_plugin_api::abi;
use thiserror::Error;

/// Numbers of edits that can be undone and redone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HistoryCounts {
    /// Number of edits that can be undone.
    pub done: usize,
    /// Number of edits that have been undone and can be redone.
    pub undone: usize,
}

/// Edits that can be undone and redone.
#[derive(Default)]
pub(super) struct History {
    pub(super) kept: bool,
    /// Tools with such an edit under way, and all bodies before it.
    under_way: Vec<(usize, SavedState)>,
    done: Vec<SavedState>,
    undone: Vec<SavedState>,
    /// The sculpt layer whose strength was the last thing to change.
    strength_of: Option<u32>,
    /// Progress of the scene's own undos and redos.
    clock: HistoryClock,
    /// Statistics of all cuts.
    pub(super) cuts: CutCounts,
    /// Number of cuts after an undo, which discard what could have been redone.
    pub(super) cut_branches: u64,
    /// Number of cuts and stitches, which fix sculpt layers.
    pub(super) topologies: u64,
}

/// State of all bodies and sculpt layers at one time.
#[derive(Clone)]
pub(super) struct SavedState {
    /// Number of each body with its state.
    bodies: Vec<(u32, BodyState)>,
    layers: SculptLayers,
    /// Ties between bodies, without those that strokes still draw together.
    ties: Ties,
}

/// The state of all bodies of a session at one time.
pub struct Snapshot {
    state: SavedState,
    steps: u64,
    clock: HistoryClock,
    cut_branches: u64,
    cuts: CutCounts,
    is_cut: bool,
}

/// Why a snapshot cannot be restored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum SnapshotError {
    /// The snapshot has a different number of bodies.
    #[error("the snapshot has {found} bodies and the session {expected}; allowed is a snapshot of the same session")]
    Bodies {
        /// Number of bodies of the snapshot.
        found: usize,
        /// Number of bodies of the session.
        expected: usize,
    },
    /// Cuts of the snapshot have been undone and replaced by other cuts.
    #[error(
        "something else was cut since the snapshot's own cuts were taken back; allowed is a snapshot without cuts, or one of the present cuts"
    )]
    Recut,
}

/// Progress of the scene's own undos and redos.
#[derive(Clone, Copy, Default)]
struct HistoryClock {
    /// Time up to which timed undos and redos have been executed, s.
    until: Option<f64>,
    /// Buttons of all hands that were pressed in the last step, as a bit mask.
    buttons: u32,
}

/// Largest number of edits that can be undone.
const MAX_UNDO: usize = 100;

impl History {
    /// Appends a state that can be restored, and forgets the oldest of too many.
    fn push(&mut self, before: SavedState) {
        self.done.push(before);
        let over = self.done.len().saturating_sub(MAX_UNDO);
        self.done.drain(..over);
    }
}

impl Session {
    /// Enables [`Session::undo`] for all following edits.
    pub fn keep_history(&mut self) {
        self.history.kept = true;
    }

    /// How many edits can be undone and redone.
    pub fn history(&self) -> HistoryCounts {
        let History { done, under_way, undone, .. } = &self.history;
        HistoryCounts { done: done.len() + under_way.len(), undone: undone.len() }
    }

    /// Restores the state before the last cut, the last edit that changed a shape or history for good, or the last change of sculpt layers. An active edit of that kind
    /// ends first and does not begin again before its button is pressed again. Returns whether there was one.
    pub fn undo(&mut self) -> bool {
        if self.history().done == 0 {
            return false;
        }
        let touching = self.touching_proxies();
        self.end_edits();
        self.history.strength_of = None;
        let Some(before) = self.history.done.pop() else { return false };
        let now = self.save();
        self.history.undone.push(now);
        self.restore_state(&before);
        self.resume_touching(&touching);
        true
    }

    /// Redoes the edit that was undone last. Returns whether there was one.
    pub fn redo(&mut self) -> bool {
        if self.history.undone.is_empty() {
            return false;
        }
        let touching = self.touching_proxies();
        self.end_edits();
        self.history.strength_of = None;
        let Some(after) = self.history.undone.pop() else { return false };
        let now = self.save();
        self.history.done.push(now);
        self.restore_state(&after);
        self.resume_touching(&touching);
        true
    }

    /// The present state of all bodies, with the time. Grips of tools are not part of it.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            state: self.save(),
            steps: self.clock.steps,
            clock: self.history.clock,
            cut_branches: self.history.cut_branches,
            cuts: self.history.cuts.clone(),
            is_cut: self.bodies.iter().any(|body| body.cut.as_ref().is_some_and(|mesh| mesh.depth() > 0)),
        }
    }

    /// Goes back, or forward, to a snapshot of this session. Tools let go of what they hold and take it up again in the next step; edits
    /// before can no longer be taken back.
    ///
    /// # Errors
    /// A snapshot of another session, or of cuts that no longer exist.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let (found, expected) = (snapshot.state.bodies.len(), self.bodies.len());
        if !snapshot.state.bodies.iter().all(|(number, _)| self.has_body(*number)) {
            return Err(SnapshotError::Bodies { found, expected });
        }
        if snapshot.is_cut && snapshot.cut_branches != self.history.cut_branches {
            return Err(SnapshotError::Recut);
        }
        // An edit that ended properly could cut once more or keep its shape; what it did is given up.
        for slot in &mut self.tools {
            (slot.edit, slot.taken_back, slot.advances) = (None, None, 0);
            slot.tool.set_action(None);
        }
        self.restore_state(&snapshot.state);
        self.clock.steps = snapshot.steps;
        self.history = History {
            kept: self.history.kept,
            clock: snapshot.clock,
            cuts: snapshot.cuts.clone(),
            cut_branches: self.history.cut_branches,
            topologies: self.history.topologies,
            ..History::default()
        };
        self.frame.time = self.time();
        Ok(())
    }

    /// The scene's undos (false) and redos (true) that are due at `time` (s): first timed ones in the order of their times, then those of buttons that
    /// have been pressed since the last step.
    pub(super) fn due_history_steps(&mut self, time: f64) -> Vec<bool> {
        let hands = self.tools.iter().filter(|slot| slot.hand.present);
        let buttons = hands.fold(0, |down, slot| down | slot.hand.buttons);
        let pressed = buttons & !self.history.clock.buttons;
        let after = self.history.clock.until.unwrap_or(f64::NEG_INFINITY);
        (self.history.clock.buttons, self.history.clock.until) = (buttons, Some(time));
        let mut timed = Vec::new();
        let mut by_button = Vec::new();
        for step in &self.plan.history_steps {
            match step.trigger {
                Trigger::Time(at) if after < at && at <= time => timed.push((at, step.redo)),
                Trigger::Button { button, span } if span.contains(time) && pressed >> button & 1 == 1 => {
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
        let leaves = edit.kind.cuts() || edit.kind.changes_body() || edit.release == Release::Keep;
        leaves || self.bodies.iter().any(|body| body.system.sets.iter().any(|set| set.has(abi::HAS_HISTORY)))
    }

    /// Records the state before an edit that begins with a tool.
    pub(super) fn remember(&mut self, tool: usize, edit: usize) {
        if self.history.kept && self.is_remembered(&self.plan.edits[edit]) {
            if self.tools[tool].mirror.is_some() {
                return; // belongs to the edit of the mirrored hand
            }
            let now = self.save();
            self.history.under_way.push((tool, now));
            self.history.undone.clear();
            self.history.strength_of = None;
        }
    }

    /// Records the present state before a change that is no edit of a tool.
    pub(super) fn remember_now(&mut self) {
        if self.history.kept {
            let now = self.save();
            self.history.undone.clear();
            self.history.strength_of = None;
            self.history.push(now);
        }
    }

    /// The last state that was recorded is not needed: nothing has changed.
    pub(super) fn forget_last(&mut self) {
        self.history.done.pop();
    }

    /// The edit of a tool is over; `changed` tells whether there is anything to take back. An undo of an edit that goes on beside it then goes back to
    /// the present state: that before it was in the middle of this one.
    pub(super) fn settle(&mut self, tool: usize, changed: bool) {
        let Some(place) = self.history.under_way.iter().position(|(t, _)| *t == tool) else { return };
        let (_, before) = self.history.under_way.remove(place);
        let has_flowed =
            || self.bodies.iter().zip(&before.bodies).any(|(body, (_, before))| before.has_other_history(body));
        if changed || has_flowed() {
            self.history.push(before);
            if !self.history.under_way.is_empty() {
                let now = self.save();
                self.history.under_way.iter_mut().for_each(|(_, before)| before.clone_from(&now));
            }
        }
    }

    /// Records the state before a change of the sculpt layers. Changes of the strength of the same layer, `strength_of`, right after each other are one.
    pub(super) fn remember_layers(&mut self, before: Option<SavedState>, strength_of: Option<u32>) {
        let Some(before) = before else { return };
        let goes_on = strength_of.is_some() && self.history.strength_of == strength_of;
        self.history.strength_of = strength_of;
        if !goes_on {
            self.history.undone.clear();
            self.history.push(before);
        }
    }

    pub(super) fn end_edits(&mut self) {
        for tool in 0..self.tools.len() {
            let Some(edit) = self.tools[tool].edit else { continue };
            self.end_edit(tool);
            self.tools[tool].taken_back = Some(edit).filter(|edit| self.is_remembered(&self.plan.edits[*edit]));
        }
    }

    /// All bodies and layers. In the middle of a cut or a stitch the layers are those that its end would leave: fixed.
    pub(super) fn save(&self) -> SavedState {
        let mut layers = self.layers.clone();
        let changes_topology = |edit: usize| self.plan.edits[edit].kind.changes_topology();
        let is_amid = self
            .tools
            .iter()
            .any(|slot| slot.advances > 0 || slot.tool.changed_body && slot.edit.is_some_and(changes_topology));
        if is_amid {
            layers.fix(self.history.topologies + 1, &self.bodies);
        }
        let bodies = self.bodies.iter().map(|body| (body.number, body.save())).collect();
        SavedState { bodies, layers, ties: self.ties.kept() }
    }

    fn restore_state(&mut self, state: &SavedState) {
        let time = self.time();
        self.layers = state.layers.clone();
        self.ties = state.ties.clone();
        // One that was saved amid a cut has a stamp that no cut has had yet.
        self.history.topologies = self.history.topologies.max(self.layers.topology());
        self.show_bodies(state.bodies.iter().map(|(number, _)| *number));
        for (index, (_, state)) in state.bodies.iter().enumerate() {
            match self.bodies[index].restore(state) {
                Ok(()) => {
                    let restored = self.bodies[index].restore_symmetry(state, &self.workers.all);
                    self.changed(index);
                    if let Err(error) = restored {
                        self.freeze(index, time, error.to_string());
                    }
                }
                Err(error) => self.freeze(index, time, error.to_string()),
            }
        }
        for slot in &mut self.tools {
            slot.tool.release(&slot.hand);
        }
        self.events.add(EventKind::History, time, || format!("at {time} s"));
    }
}
