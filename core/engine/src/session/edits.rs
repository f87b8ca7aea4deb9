//! Begin and end of edits, and cutting.

use super::event::EventKind;
use super::{CutCounts, Session};
use crate::body::{Body, LatticeError, Repair, Unfolded};
use crate::edit::{CutAgain, HeldBody};
use crate::scene::Release;
use pliant_solver::Vec3;
use std::time::Instant;

/// Most cells by which a repair may move a node of a shape that is kept. What is left of a stroke after more than that is not the shape that the hand gave.
const MAX_REPAIR: f64 = 4.0;

impl Session {
    /// Begins and ends edits, and executes the scene's undos and redos.
    pub(super) fn change_modes(&mut self, time: f64) {
        for redo in self.due_history_steps(time) {
            if !(if redo { self.redo() } else { self.undo() }) {
                let what = if redo { "redo" } else { "undo" };
                self.events.add(EventKind::History, time, || format!("nothing to {what}"));
            }
        }
        for tool in 0..self.tools.len() {
            let (before, now) = (self.tools[tool].edit, self.edit_of(tool));
            if before == now {
                continue;
            }
            let touching = self.tools[tool].touching_proxy().filter(|_| now.is_some());
            let cuts = self.editing.history.cuts.advances;
            self.end_edit(tool);
            // A hand that presses is inside of the body: the next edit meets the surface from outside, where the proxy is. A cut may have taken that away.
            if let Some(proxy) = touching.filter(|_| self.editing.history.cuts.advances == cuts) {
                self.resume_touching(&[proxy]);
            }
            if let Some(edit) = now {
                if self.plan.edits[edit].kind.changes_topology() {
                    self.editing.layers.assign(&self.bodies);
                }
                self.begin_symmetric_edit(tool);
                self.remember(tool, edit);
            }
            let slot = &mut self.tools[tool];
            slot.edit = now;
            let bodies = self.bodies.len();
            let action = now.map(|edit| &self.plan.edits[edit]).map(|edit| edit.kind.begin(edit, &slot.tool, bodies));
            slot.tool.set_action(action);
            slot.begin_where_asked();
        }
    }

    /// Ends the active edit of a tool, if there is one.
    pub(super) fn end_edit(&mut self, tool: usize) {
        let time = self.time();
        let ended = self.tools[tool].edit.take();
        if let Some(index) = ended {
            let edit = &self.plan.edits[index].clone();
            self.cut_with(tool, time, true);
            let lost_grip = std::mem::take(&mut self.tools[tool].has_lost_grip);
            let keeps = edit.release == Release::Keep && !edit.kind.changes_body();
            let drifted = keeps && lost_grip && self.spring_back(tool, time);
            let kept = keeps && !lost_grip && self.keep(time);
            let slot = &mut self.tools[tool];
            let advances = std::mem::take(&mut slot.advances);
            let cut = advances > 0;
            let changed_body = std::mem::take(&mut slot.tool.changed_body);
            let has_tied = std::mem::take(&mut slot.has_tied);
            slot.is_stitch_refused = false;
            // What its stroke was drawing together is let go.
            self.interactions.ties.drop_drawn(tool);
            self.warnings.tally_ended(index, advances, changed_body || has_tied);
            if cut {
                self.finish_cuts(time, Body::refine_cut_surfaces);
            }
            // They have the vertices of the cut faces too.
            if cut || changed_body && edit.kind.changes_topology() {
                self.fix_layers(time);
            }
            if cut {
                self.finish_cuts(time, Body::part_by_surface);
            }
            if cut && edit.splits {
                self.split_cut_bodies();
            }
            self.settle(tool, cut || changed_body || has_tied || kept || drifted);
        }
        let slot = &mut self.tools[tool];
        slot.tool.release(&slot.hand);
        slot.tool.set_action(None);
    }

    /// Finishes the cuts of each body in some way. One whose plugin fails is frozen.
    fn finish_cuts(&mut self, time: f64, finish: impl Fn(&mut Body) -> Result<(), LatticeError>) {
        for index in 0..self.bodies.len() {
            if let Err(error) = finish(&mut self.bodies[index]) {
                self.freeze(index, time, error.to_string());
            }
        }
    }

    /// The connectivity has changed: sculpt layers from before are fixed.
    pub(super) fn fix_layers(&mut self, time: f64) {
        if let Some(name) = self.editing.fix_layers(&self.bodies) {
            self.events.add(EventKind::LayerFixed, time, || {
                format!(
                    "layer `{name}` ends at a cut or stitch, for its strength is fixed from there on; strokes go to the base until there is a \
                     new layer"
                )
            });
        }
    }

    /// Cuts with all active blades.
    pub(super) fn cut(&mut self, time: f64) {
        for tool in 0..self.tools.len() {
            self.cut_with(tool, time, false);
        }
    }

    fn cut_with(&mut self, tool: usize, time: f64, last: bool) {
        // At the end of an edit that of the original may be over already.
        if !last {
            self.tools[tool].cuts_the_same = self.cuts_the_same(tool);
        }
        if self.tools[tool].cuts_the_same {
            // It takes up its cut anew where it is elsewhere.
            let slot = &mut self.tools[tool];
            slot.tool.release(&slot.hand);
            return;
        }
        let began = Instant::now();
        let is_behind = self.bodies.iter().any(|body| body.cut.as_ref().is_some_and(|mesh| mesh.undone() > 0));
        let slot = &mut self.tools[tool];
        let stitch = if last { None } else { slot.tool.stitch_request(&self.bodies) };
        match slot.tool.cut(&slot.hand, &mut self.bodies, last) {
            Ok(step) => {
                slot.advances += step.advances;
                self.editing.history.record_cut(&step, is_behind, began.elapsed().as_secs_f64());
                if let Some((body, refused)) = step.refused {
                    let (tool, body) = (&slot.tool.name, &self.bodies[body].name);
                    self.events
                        .add(EventKind::CutRefused, time, || format!("tool `{tool}` in body `{body}`: {refused}"));
                }
                if let Some(held) = step.held {
                    let (tool, body) = (&slot.tool.name, &self.bodies[held.body].name);
                    let HeldBody { place, width, resistance, pull, .. } = held;
                    self.events.add(EventKind::CutHeld, time, || {
                        let why = match resistance > 0.0 {
                            true => format!(
                                "the cut resists with {resistance:.3} N and the hand pulls with {pull:.3} N; draw the blade farther, or \
                                 give it a lower `toughness`"
                            ),
                            false => "the mesh cannot be cut there; cut it again beside".to_owned(),
                        };
                        let (at, width) = (place_in_mm(place), 1e3 * width);
                        format!(
                            "tool `{tool}` was drawn right through body `{body}`, whose parts still hold together near {at}, over at \
                             most {width:.3} mm: {why}"
                        )
                    });
                }
                if let Some(CutAgain { body, place, way }) = step.again {
                    let (tool, body) = (&slot.tool.name, &self.bodies[body].name);
                    self.events.add(EventKind::CutAgain, time, || {
                        let (at, way) = (place_in_mm(place), 1e3 * way);
                        format!(
                            "tool `{tool}` went along an earlier cut of body `{body}` from near {at} on, {way:.1} mm far, and cut nothing \
                             there: cuts closer than 0.4 of a cell are one; cut farther beside, or across at more than 0.2 rad"
                        )
                    });
                }
            }
            Err(error) => {
                self.events.add(EventKind::Message, time, || error.to_string());
                slot.tool.release(&slot.hand);
            }
        }
        if let Some(request) = stitch {
            self.stitch_to_others(tool, request, time);
        }
    }

    /// Makes the current shape of all bodies their rest shape. Returns whether any was another one.
    fn keep(&mut self, time: f64) -> bool {
        let mut has_changed = false;
        for index in 0..self.bodies.len() {
            let body = &mut self.bodies[index];
            if body.system.nodes.is_empty() || body.frozen.is_some() {
                continue;
            }
            // What has failed has no shape to keep: its nodes may be anywhere, and pieces that have parted would be joined.
            let failed = body.system.failed_count();
            if failed > 0 && body.discretization.lattice().is_some() {
                let name = &body.name;
                self.events.add(EventKind::NotKept, time, || {
                    format!(
                        "body `{name}`: {failed} of its elements have failed, so its shape springs back; allowed for `release = \"keep\"` is a \
                         solid that is whole"
                    )
                });
                continue;
            }
            if let Some(Repair { cells, place, moved }) = untangle(body) {
                let most = MAX_REPAIR * body.discretization.edge();
                let (at, is_kept, name) = (place_in_mm(place), moved <= most, &body.name);
                let [moved, most] = [moved, most].map(|way| 1e3 * way);
                if !is_kept {
                    self.events.add(EventKind::NotKept, time, || {
                        format!(
                            "body `{name}`: {cells} cells near {at} were inverted or flat, and their repair would move nodes by {moved:.3} mm, \
                             so its last shape is back; allowed for `release = \"keep\"` is a repair by up to {most:.3} mm"
                        )
                    });
                    go_to_rest(body);
                    continue;
                }
                self.events.add(EventKind::Repaired, time, || {
                    format!(
                        "body `{name}`: {cells} cells near {at} were inverted or flat when the shape was kept; their nodes were \
                         moved by at most {moved:.3} mm"
                    )
                });
            }
            has_changed |= body.system.nodes.x != body.system.nodes.rest;
            let most = MAX_REPAIR * body.discretization.edge();
            let Unfolded { edges, left, moved, place } = match body.keep(self.motion.pool(), most) {
                Ok(unfolded) => unfolded,
                Err(error) => {
                    self.freeze(index, time, error.to_string());
                    continue;
                }
            };
            if edges > 0 {
                let (name, moved) = (&body.name, 1e3 * moved);
                self.events.add(EventKind::Repaired, time, || {
                    format!(
                        "body `{name}`: its surface was folded at {edges} edges when the shape was kept; vertices there were moved by at most {moved:.3} mm"
                    )
                });
            }
            if left > 0 {
                let (name, most, at) = (&body.name, 1e3 * most, place_in_mm(place));
                self.events.add(EventKind::FoldsLeft, time, || {
                    format!(
                        "body `{name}`: the shape was kept with its surface folded at {left} edges, some of them near {at}; unfolding them would move vertices by more \
                         than {most:.3} mm or leave folds; undo the stroke, or smooth there"
                    )
                });
            }
            self.changed(index);
        }
        has_changed
    }

    /// Lets the bodies go back to their last shape after an edit whose hand has let go of them. Cells that are inside out, in which a material may be at rest, do
    /// so at once. Returns whether a body that is simulated as a whole has moved: it may not come back to the same place.
    fn spring_back(&mut self, tool: usize, time: f64) -> bool {
        for body in self.bodies.iter_mut().filter(|body| body.frozen.is_none()) {
            if untangle(body).is_some() {
                go_to_rest(body);
            }
        }
        let name = &self.tools[tool].tool.name;
        self.events.add(EventKind::NotKept, time, || {
            format!(
                "tool `{name}`: it had let go before its edit ended, so what it has moved springs back; allowed for `release = \"keep\"` is a force up to the \
                 `limit` of the edit"
            )
        });
        let has_moved = |body: &Body| body.system.nodes.x != body.system.nodes.rest;
        self.bodies.iter().any(|body| body.discretization.is_whole() && has_moved(body))
    }

    /// Statistics of all cuts so far.
    pub fn cuts(&self) -> &CutCounts {
        &self.editing.history.cuts
    }
}

/// Moves the nodes of a solid as [`crate::body::Lattice::untangle`] does.
fn untangle(body: &mut Body) -> Option<Repair> {
    let (lattice, nodes) = (body.discretization.lattice()?, &mut body.system.nodes);
    lattice.untangle(nodes)
}

/// Takes the free nodes of a body back to their last shape, with zero velocity.
fn go_to_rest(body: &mut Body) {
    let nodes = &mut body.system.nodes;
    for node in (0..nodes.len()).filter(|node| nodes.constraint[*node].is_free()) {
        (nodes.x[node], nodes.v[node]) = (nodes.rest[node], Vec3::zeros());
    }
}

/// A place (m) for people, such as `[1.500, 0.000, -20.250] mm`.
fn place_in_mm(place: Vec3) -> String {
    let [x, y, z] = (1e3 * place).into();
    format!("[{x:.3}, {y:.3}, {z:.3}] mm")
}
