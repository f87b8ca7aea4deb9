//! What edits have made of the bodies of a session, and what is kept to take it back.

use super::division::DividedBodies;
use super::history::History;
use super::sculpt_layers::SculptLayers;
use crate::body::{Axes, Body, SymmetryPlane};
use pliant_solver::Vec3;
use std::sync::Arc;

/// States that can be undone, sculpt layers, bodies that were split, and the symmetry of edits.
pub(super) struct Editing {
    /// States that can be undone and redone, and statistics of cuts.
    pub(super) history: History,
    /// Sculpt layers, each with its strength, and where strokes go.
    pub(super) layers: SculptLayers,
    /// Bodies that were split, and their parts.
    pub(super) divided: DividedBodies,
    /// Planes of a symmetry that the next step pairs the vertices of bodies for.
    pub(super) unpaired: Option<Vec<SymmetryPlane>>,
    /// Axes and centre (m) of a symmetry that was asked for during an edit.
    pub(super) next_symmetry: Option<(Axes, Vec3)>,
}

impl Editing {
    /// Nothing edited yet, in a scene with this number of moving bodies. The vertices of bodies are to be paired about the planes of `unpaired`.
    pub(super) fn new(bodies: usize, unpaired: Option<Vec<SymmetryPlane>>) -> Self {
        Self {
            history: History::default(),
            layers: SculptLayers::default(),
            divided: DividedBodies::new(bodies),
            unpaired,
            next_symmetry: None,
        }
    }

    /// The connectivity of bodies has changed: sculpt layers from before are fixed. Returns the name of the layer that recorded strokes.
    pub(super) fn fix_layers(&mut self, bodies: &[Body]) -> Option<Arc<str>> {
        self.history.topologies += 1;
        self.layers.fix(self.history.topologies, bodies)
    }

    /// Sets the layers to those of a saved state.
    pub(super) fn restore_layers(&mut self, layers: &SculptLayers) {
        self.layers = layers.clone();
        // One that was saved during a cut has a stamp that no cut has had yet.
        self.history.topologies = self.history.topologies.max(self.layers.topology());
    }
}
