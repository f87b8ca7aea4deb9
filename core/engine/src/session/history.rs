//! Undo, redo and snapshots of shape, motion and cuts.
//!
//! The size of a saved state is that of the active nodes and the cuts; the surface is shared until it changes.

use super::sculpt_layers::SculptLayers;
use super::ties::Ties;
use super::{EventKind, Session};
use crate::body::BodyState;
use crate::edit::CutStep;
use crate::plan::{Edit, HistoryStep, Trigger};
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

/// Statistics of cuts.
#[derive(Clone, Debug, Default)]
pub struct CutCounts {
    /// Number of advances that changed a mesh.
    pub advances: usize,
    /// Cut area of closed bodies, of one of the two walls, m^2.
    pub area: f64,
    /// Cut length, of one of the two sides, m.
    pub length: f64,
    /// Wall-clock time of cutting in each step with an advance, s: mesh, model, lattice and samples.
    pub seconds: Vec<f64>,
}

/// Edits that can be undone and redone.
#[derive(Default)]
pub(super) struct History {
    /// Whether states are kept.
    pub(super) kept: bool,
    /// Tools with such an edit under way, and all bodies before it.
    under_way: Vec<(usize, SavedState)>,
    done: Vec<SavedState>,
    undone: Vec<SavedState>,
    /// Number of edits that were dropped because there were more than [`MAX_UNDO`].
    forgotten: u64,
    /// The sculpt layer whose strength was the last thing to change.
    strength_of: Option<u32>,
    /// Progress of the scene's own undos and redos.
    clock: HistoryClock,
    /// Statistics of all cuts.
    pub(super) cuts: CutCounts,
    /// Number of cuts after an undo, which discard what could have been redone.
    cut_branches: u64,
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
    /// How many edits can be undone and redone.
    fn counts(&self) -> HistoryCounts {
        HistoryCounts { done: self.done.len() + self.under_way.len(), undone: self.undone.len() }
    }

    /// Appends a state that can be restored, and forgets the oldest of too many.
    fn push(&mut self, before: SavedState) {
        self.done.push(before);
        let over = self.done.len().saturating_sub(MAX_UNDO);
        self.done.drain(..over);
        self.forgotten += over as u64;
    }

    /// What was undone cannot be redone: something else changes.
    fn branch(&mut self) {
        self.undone.clear();
        self.strength_of = None;
    }

    /// The state before the last edit, or with `redo` after the one that was undone last, in exchange for the present state; `None` without one.
    fn exchange(&mut self, now: SavedState, redo: bool) -> Option<SavedState> {
        self.strength_of = None;
        let (from, to) = if redo { (&mut self.undone, &mut self.done) } else { (&mut self.done, &mut self.undone) };
        let state = from.pop()?;
        to.push(now);
        Some(state)
    }

    /// The last state that was recorded is not needed: nothing has changed.
    pub(super) fn forget_last(&mut self) {
        self.done.pop();
    }

    /// The edit of a tool is over. Its state before is kept if `has_changed` says that there is anything to take back; returns whether it is.
    fn settle(&mut self, tool: usize, has_changed: impl FnOnce(&SavedState) -> bool) -> bool {
        let Some(place) = self.under_way.iter().position(|(t, _)| *t == tool) else { return false };
        let (_, before) = self.under_way.remove(place);
        let is_recorded = has_changed(&before);
        if is_recorded {
            self.push(before);
        }
        is_recorded
    }

    /// Records the state before a change of the sculpt layers. Changes of the strength of the same layer, `strength_of`, right after each other are one.
    pub(super) fn record_layers(&mut self, before: SavedState, strength_of: Option<u32>) {
        let goes_on = strength_of.is_some() && self.strength_of == strength_of;
        self.strength_of = strength_of;
        if !goes_on {
            self.undone.clear();
            self.push(before);
        }
    }

    /// Adds advances of a blade to the statistics. `is_behind` says that cuts had been undone, which can now not be redone.
    pub(super) fn record_cut(&mut self, step: &CutStep, is_behind: bool, seconds: f64) {
        if step.advances > 0 {
            self.cut_branches += u64::from(is_behind);
            self.cuts.advances += step.advances;
            self.cuts.area += step.area;
            self.cuts.length += step.length;
            self.cuts.seconds.push(seconds);
        }
    }

    /// Those of a scene's undos (false) and redos (true) that are due at `time` (s): first timed ones in the order of their times, then those of `buttons`
    /// that have been pressed since the last step.
    fn due(&mut self, steps: &[HistoryStep], buttons: u32, time: f64) -> Vec<bool> {
        let pressed = buttons & !self.clock.buttons;
        let after = self.clock.until.unwrap_or(f64::NEG_INFINITY);
        self.clock = HistoryClock { until: Some(time), buttons };
        let mut timed = Vec::new();
        let mut by_button = Vec::new();
        for step in steps {
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

    /// Goes to the time of a snapshot; nothing can be undone or redone there.
    fn go_to(&mut self, snapshot: &Snapshot) {
        *self = Self {
            kept: self.kept,
            clock: snapshot.clock,
            cuts: snapshot.cuts.clone(),
            cut_branches: self.cut_branches,
            topologies: self.topologies,
            ..Self::default()
        };
    }
}

impl Session {
    /// Enables [`Session::undo`] for all following edits.
    pub fn keep_history(&mut self) {
        self.editing.history.kept = true;
    }

    /// How many edits can be undone and redone.
    pub fn history(&self) -> HistoryCounts {
        self.editing.history.counts()
    }

    /// Number of edits that can no longer be undone because more than 100 came after them.
    pub fn edits_forgotten(&self) -> u64 {
        self.editing.history.forgotten
    }

    /// Number of edits among those that can be undone that have not ended yet.
    pub fn edits_under_way(&self) -> usize {
        self.editing.history.under_way.len()
    }

    /// Restores the state before the last cut, the last edit that changed a shape or history for good, or the last change of sculpt layers. An active edit of that kind
    /// ends first and does not begin again before its button is pressed again. Returns whether there was one.
    pub fn undo(&mut self) -> bool {
        self.history().done > 0 && self.exchange_states(false)
    }

    /// Redoes the edit that was undone last. Returns whether there was one.
    pub fn redo(&mut self) -> bool {
        self.history().undone > 0 && self.exchange_states(true)
    }

    /// Ends active edits, and undoes or redoes one. Returns whether there was one.
    fn exchange_states(&mut self, redo: bool) -> bool {
        let touching = self.touching_proxies();
        self.end_edits();
        let now = self.save();
        let Some(state) = self.editing.history.exchange(now, redo) else { return false };
        self.restore_state(&state);
        self.resume_touching(&touching);
        true
    }

    /// The present state of all bodies, with the time. Grips of tools are not part of it.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            state: self.save(),
            steps: self.clock.steps,
            clock: self.editing.history.clock,
            cut_branches: self.editing.history.cut_branches,
            cuts: self.editing.history.cuts.clone(),
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
        if snapshot.is_cut && snapshot.cut_branches != self.editing.history.cut_branches {
            return Err(SnapshotError::Recut);
        }
        // An edit that ended properly could cut once more or keep its shape; what it did is given up.
        for slot in &mut self.tools {
            (slot.edit, slot.taken_back, slot.advances) = (None, None, 0);
            slot.tool.set_action(None);
        }
        self.restore_state(&snapshot.state);
        self.clock.steps = snapshot.steps;
        self.editing.history.go_to(snapshot);
        self.frame.time = self.time();
        Ok(())
    }

    /// The scene's undos (false) and redos (true) that are due at `time` (s), see [`History::due`].
    pub(super) fn due_history_steps(&mut self, time: f64) -> Vec<bool> {
        let hands = self.tools.iter().filter(|slot| slot.hand.present);
        let buttons = hands.fold(0, |down, slot| down | slot.hand.buttons);
        self.editing.history.due(&self.plan.history_steps, buttons, time)
    }

    /// Whether an edit is one that can be taken back. Where a material has a history, as clay has, any edit may leave something.
    fn is_remembered(&self, edit: &Edit) -> bool {
        let leaves = edit.kind.cuts() || edit.kind.changes_body() || edit.release == Release::Keep;
        leaves || self.bodies.iter().any(|body| body.system.sets.iter().any(|set| set.has(abi::HAS_HISTORY)))
    }

    /// Records the state before an edit that begins with a tool. One of a mirrored tool belongs to the edit of its original.
    pub(super) fn remember(&mut self, tool: usize, edit: usize) {
        let is_recorded = self.editing.history.kept && self.is_remembered(&self.plan.edits[edit]);
        if is_recorded && self.tools[tool].mirror.is_none() {
            let now = self.save();
            self.editing.history.under_way.push((tool, now));
            self.editing.history.branch();
        }
    }

    /// Records the present state before a change that is no edit of a tool.
    pub(super) fn remember_now(&mut self) {
        if self.editing.history.kept {
            let now = self.save();
            self.editing.history.branch();
            self.editing.history.push(now);
        }
    }

    /// The edit of a tool is over; `changed` tells whether there is anything to take back. An undo of an edit that goes on beside it then goes back to
    /// the present state: that before it was in the middle of this one.
    pub(super) fn settle(&mut self, tool: usize, changed: bool) {
        let is_recorded = self.editing.history.settle(tool, |before| {
            let mut bodies = self.bodies.iter().zip(&before.bodies);
            changed || bodies.any(|(body, (_, before))| before.has_other_history(body))
        });
        if is_recorded && !self.editing.history.under_way.is_empty() {
            let now = self.save();
            self.editing.history.under_way.iter_mut().for_each(|(_, before)| before.clone_from(&now));
        }
    }

    /// Ends all active edits. Those that can be taken back do not go on.
    pub(super) fn end_edits(&mut self) {
        for tool in 0..self.tools.len() {
            let Some(edit) = self.tools[tool].edit else { continue };
            self.end_edit(tool);
            self.tools[tool].taken_back = Some(edit).filter(|edit| self.is_remembered(&self.plan.edits[*edit]));
        }
    }

    /// All bodies and layers. In the middle of a cut or a stitch the layers are those that its end would leave: fixed.
    pub(super) fn save(&self) -> SavedState {
        let changes_topology = |edit: usize| self.plan.edits[edit].kind.changes_topology();
        let is_amid = self
            .tools
            .iter()
            .any(|slot| slot.advances > 0 || slot.tool.changed_body && slot.edit.is_some_and(changes_topology));
        let mut layers = self.editing.layers.clone();
        if is_amid {
            layers.fix(self.editing.history.topologies + 1, &self.bodies);
        }
        let bodies = self.bodies.iter().map(|body| (body.number, body.save())).collect();
        SavedState { bodies, layers, ties: self.interactions.ties.kept() }
    }

    fn restore_state(&mut self, state: &SavedState) {
        let time = self.time();
        self.editing.restore_layers(&state.layers);
        self.interactions.ties = state.ties.clone();
        self.show_bodies(state.bodies.iter().map(|(number, _)| *number));
        for (index, (_, state)) in state.bodies.iter().enumerate() {
            match self.bodies[index].restore(state) {
                Ok(()) => {
                    let restored = self.bodies[index].restore_symmetry(state, self.motion.pool());
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
