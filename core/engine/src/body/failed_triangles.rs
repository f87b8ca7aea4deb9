//! Triangles that have failed because the material says so (`pliant.failure/1`), of a sheet, or of a solid with its tetrahedra: they are neither drawn nor
//! written, and nothing meets them. A sheet's vertices stay, with their mass, and are met as long as they have another triangle.
//!
//! Whether an element has failed follows from its history, so an undo, which puts histories back, brings its triangle back too.

use super::broken_surface::ExposedFaces;
use super::{Body, LatticeError};
use pliant_plugin_api::abi;
use pliant_solver::{ElementSet, System};
use std::sync::Arc;

/// What failure has changed of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FailureChange {
    /// How many more elements have failed.
    pub elements: usize,
    /// Whether triangles of a solid have gone, come back or come to light.
    pub surface: bool,
}

/// The triangles of a body that have failed.
#[derive(Clone, Debug, Default)]
pub struct FailedTriangles {
    /// Whether each triangle has failed; empty if none has.
    has_failed: Vec<bool>,
    /// Nodes all of whose triangles have failed, ascending.
    loose_nodes: Vec<u32>,
    /// Number of elements of the body that have failed.
    elements: usize,
    /// Number of changes of the elements' list that `has_failed` has been brought up to date with.
    changes: u64,
    /// Faces of a solid that have come to light.
    pub(super) exposed: ExposedFaces,
}

impl FailedTriangles {
    /// Whether a triangle has failed.
    pub fn contains(&self, triangle: u32) -> bool {
        self.has_failed.get(triangle as usize).copied().unwrap_or(false)
    }

    /// Nodes that have triangles, all of which have failed, ascending: nothing of them is seen, and nothing meets them.
    pub fn loose_nodes(&self) -> &[u32] {
        &self.loose_nodes
    }

    /// Faces of a solid that have come to light where elements have failed.
    pub fn exposed(&self) -> &ExposedFaces {
        &self.exposed
    }

    /// Whether the elements have changed since the last call: `changes` counts all changes so far.
    pub(super) fn take_changes(&mut self, changes: u64) -> bool {
        std::mem::replace(&mut self.changes, changes) != changes
    }

    /// Marks the triangles as out of date: the next [`Body::update_failed_triangles`] finds them anew.
    pub(super) fn outdate(&mut self) {
        self.changes = u64::MAX;
    }

    /// Replaces which triangles have failed (t). Returns those that have changed.
    pub(super) fn replace(&mut self, has_failed: Vec<bool>) -> Vec<u32> {
        let before = std::mem::replace(&mut self.has_failed, has_failed);
        let was_failed = |t: usize| before.get(t).copied().unwrap_or(false);
        let changed = (0..self.has_failed.len()).filter(|t| self.has_failed[*t] != was_failed(*t));
        changed.map(|t| t as u32).collect()
    }

    /// Whether no triangle has failed.
    pub fn is_empty(&self) -> bool {
        !self.has_failed.contains(&true)
    }
}

impl Body {
    /// How many elements have failed, of how many, and what mass hangs on none that has not, for people.
    pub(crate) fn describe_failed(&self) -> String {
        let System { sets, nodes, .. } = &self.system;
        let able = || sets.iter().filter(|set| set.has(abi::CAN_FAIL));
        let (failed, all): (usize, usize) =
            able().fold((0, 0), |(f, a), set| (f + set.failed_count(), a + set.count()));
        // By elements that are left or cannot fail; one that has a single node holds it on nothing.
        let mut is_held = vec![false; nodes.len()];
        for set in sets.iter().filter(|set| set.stencil() > 1) {
            let has_failed = |element: usize| set.failed().get(element).is_some_and(|failed| *failed != 0);
            let left = set.nodes().chunks_exact(set.stencil()).enumerate();
            let left =
                left.filter(|(stencil, _)| (0..set.parts()).any(|part| !has_failed(stencil * set.parts() + part)));
            left.flat_map(|(_, nodes)| nodes).for_each(|node| is_held[*node as usize] = true);
        }
        let loose: f64 = nodes.mass.iter().zip(&is_held).filter(|(_, held)| !**held).map(|(mass, _)| mass).sum();
        let fate = if loose > 0.0 {
            format!("{loose:.3e} kg hang on nothing and are no longer seen or met")
        } else {
            "all mass hangs on elements that are left".into()
        };
        format!("{failed} of {all} elements that can fail; {fate}")
    }

    /// Brings the triangles that have failed up to date with the elements, and marks those that have changed for viewers. Returns what has changed since the last
    /// call.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(crate) fn update_failed_triangles(&mut self) -> Result<FailureChange, LatticeError> {
        let elements = self.system.failed_count();
        let before = std::mem::replace(&mut self.failed_triangles.elements, elements);
        let can_fail = |set: &&ElementSet| set.request().kind == abi::TRIANGLE && set.has(abi::CAN_FAIL);
        let of_triangles = self.system.sets.iter().find(can_fail);
        let (Some(sheet), Some(set)) = (self.discretization.sheet(), of_triangles) else {
            let surface = self.update_broken_surface()?;
            return Ok(FailureChange { elements: elements.saturating_sub(before), surface });
        };
        // Elements that are made anew count as a change, so it also covers triangles with other numbers after a cut.
        let has_changed = self.failed_triangles.take_changes(set.failed_changes());
        if has_changed && (before > 0 || elements > 0 || !self.failed_triangles.is_empty()) {
            self.failed_triangles.has_failed.resize(self.model.surface.triangles.len(), false);
            let (mut changed, failed) = (Vec::new(), set.failed());
            for (element, failed) in failed.iter().enumerate() {
                let triangle = sheet.triangle_of(element);
                let has_failed = &mut self.failed_triangles.has_failed[triangle as usize];
                if std::mem::replace(has_failed, *failed != 0) != (*failed != 0) {
                    changed.push(triangle);
                }
            }
            if !changed.is_empty() {
                let model = Arc::make_mut(&mut self.model);
                changed.iter().for_each(|triangle| model.pages.mark(*triangle));
            }
            let FailedTriangles { has_failed, loose_nodes, .. } = &mut self.failed_triangles;
            let nodes_of = |failed: bool| {
                let those = (0_u32..).zip(has_failed.iter()).filter(move |(_, has_failed)| **has_failed == failed);
                those.flat_map(|(triangle, _)| sheet.nodes_of(&self.model, triangle))
            };
            loose_nodes.clear();
            loose_nodes.extend(nodes_of(true));
            loose_nodes.sort_unstable();
            loose_nodes.dedup();
            // By node and not by vertex: vertices of a seam share one.
            let mut is_held = vec![false; loose_nodes.len()];
            nodes_of(false).filter_map(|node| loose_nodes.binary_search(&node).ok()).for_each(|at| is_held[at] = true);
            let mut held = is_held.iter();
            loose_nodes.retain(|_| !held.next().copied().unwrap_or(false));
        }
        Ok(FailureChange { elements: elements.saturating_sub(before), surface: false })
    }
}
