//! Triangles of a sheet that have failed because the material says so (`pliant.failure/1`): they are neither drawn nor written, and nothing meets
//! them. Their vertices stay, with their mass, and are met as long as they have another triangle.
//!
//! Whether an element has failed follows from its history, so an undo, which puts histories back, brings its triangle back too.

use super::Body;
use pliant_plugin_api::abi;
use pliant_solver::ElementSet;
use std::sync::Arc;

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

    /// Whether no triangle has failed.
    pub fn is_empty(&self) -> bool {
        !self.has_failed.contains(&true)
    }
}

impl Body {
    /// Brings the triangles that have failed up to date with the elements, and marks those that have changed for viewers. Returns how many more elements
    /// have failed than at the last call.
    pub(crate) fn update_failed_triangles(&mut self) -> usize {
        let elements = self.system.failed_count();
        let before = std::mem::replace(&mut self.failed_triangles.elements, elements);
        let can_fail = |set: &&ElementSet| set.request().kind == abi::TRIANGLE && set.has(abi::CAN_FAIL);
        let of_triangles = self.system.sets.iter().find(can_fail);
        let (Some(sheet), Some(set)) = (self.discretization.sheet(), of_triangles) else {
            return elements.saturating_sub(before);
        };
        // Elements that are made anew count as a change, so it also covers triangles with other numbers after a cut.
        let changes = std::mem::replace(&mut self.failed_triangles.changes, set.failed_changes());
        if changes != set.failed_changes() && (before > 0 || elements > 0 || !self.failed_triangles.is_empty()) {
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
        elements.saturating_sub(before)
    }
}
