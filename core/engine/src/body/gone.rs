//! Triangles of a sheet that are gone because the material says so (`pliant.failure/1`): they are neither drawn nor written nor touched.
//!
//! Whether an element is gone follows from its history, so an undo, which puts histories back, brings its triangle back too.

use super::Body;
use pliant_plugin_api::abi;
use pliant_solver::ElementSet;
use std::sync::Arc;

/// The triangles of a body that are gone.
#[derive(Clone, Debug, Default)]
pub struct GoneTriangles {
    /// Whether each triangle is gone; empty if none is.
    is_gone: Vec<bool>,
    /// Number of elements of the body that are gone.
    elements: usize,
    /// Number of changes of the elements' list that `is_gone` has been brought up to date with.
    changes: u64,
}

impl GoneTriangles {
    /// Whether a triangle is gone.
    pub fn contains(&self, triangle: u32) -> bool {
        self.is_gone.get(triangle as usize).copied().unwrap_or(false)
    }

    /// Whether no triangle is gone.
    pub fn is_empty(&self) -> bool {
        !self.is_gone.contains(&true)
    }
}

impl Body {
    /// Brings the triangles that are gone up to date with the elements, and marks those that have changed for viewers. Returns how many more elements
    /// are gone than at the last call.
    pub(crate) fn update_gone(&mut self) -> usize {
        let elements = self.system.failed_count();
        let before = std::mem::replace(&mut self.gone.elements, elements);
        let can_fail = |set: &&ElementSet| set.request().kind == abi::TRIANGLE && set.has(abi::CAN_FAIL);
        let of_triangles = self.system.sets.iter().find(can_fail);
        let (Some(sheet), Some(set)) = (self.discretization.sheet(), of_triangles) else {
            return elements.saturating_sub(before);
        };
        // Elements that are made anew count as a change, so it also covers triangles with other numbers after a cut.
        let changes = std::mem::replace(&mut self.gone.changes, set.failed_changes());
        if changes != set.failed_changes() && (before > 0 || elements > 0 || !self.gone.is_empty()) {
            self.gone.is_gone.resize(self.model.surface.triangles.len(), false);
            let (mut changed, failed) = (Vec::new(), set.failed());
            for (element, failed) in failed.iter().enumerate() {
                let triangle = sheet.triangle_of(element);
                let is_gone = &mut self.gone.is_gone[triangle as usize];
                if std::mem::replace(is_gone, *failed != 0) != (*failed != 0) {
                    changed.push(triangle);
                }
            }
            if !changed.is_empty() {
                let model = Arc::make_mut(&mut self.model);
                changed.iter().for_each(|triangle| model.pages.mark(*triangle));
            }
        }
        elements.saturating_sub(before)
    }
}
