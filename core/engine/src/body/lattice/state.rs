//! Saved state of a lattice, for undo and snapshots.

use super::paint::LatticePaint;
use super::point_bindings::PointBindings;
use super::{Fragments, Lattice, LatticeError, RestOffsets};
use crate::body::fixing::Fixing;
use crate::body::model::Model;
use crate::body::skin::Skin;
use pliant_host::Region;
use pliant_plugin_api::abi::Ball;
use pliant_solver::{Nodes, System};

/// Saved state of a lattice without its nodes; its size grows with the active region and the cuts. Fields are those of [`Lattice`].
#[derive(Clone)]
pub struct LatticeState {
    pub(super) region: Region,
    pub(super) contact_balls: Vec<Ball>,
    pub(super) last_contact_balls: Vec<Ball>,
    pub(super) rest_offsets: RestOffsets,
    pub(super) fragments: Fragments,
    pub(super) bindings: PointBindings,
    pub(super) needs_rebuild: bool,
    pub(super) steps: u32,
    pub(super) is_nearly_whole: bool,
    pub(super) paint: LatticePaint,
}

impl LatticeState {
    /// Replaces the displacements of the rest positions of nodes.
    pub(in crate::body) fn set_rest_offsets(&mut self, offsets: &RestOffsets) {
        self.rest_offsets.clone_from(offsets);
    }
}

impl Lattice {
    /// Saves the state.
    pub fn save(&self) -> LatticeState {
        LatticeState {
            region: self.region.clone(),
            contact_balls: self.contact_balls.clone(),
            last_contact_balls: self.last_contact_balls.clone(),
            rest_offsets: self.rest_offsets.clone(),
            fragments: self.fragments.clone(),
            bindings: self.bindings.clone(),
            needs_rebuild: self.needs_rebuild,
            steps: self.steps,
            is_nearly_whole: self.is_nearly_whole,
            paint: self.paint.clone(),
        }
    }

    /// Restores a saved state, with all nodes at rest. The model must have been restored before, and the skin must be settled.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn restore(
        &mut self,
        state: &LatticeState,
        model: &Model,
        fixings: &[Fixing],
        skin: &mut Skin,
        system: &mut System,
    ) -> Result<(), LatticeError> {
        let state = state.clone();
        (self.region, self.spare) = (Region::default(), state.region);
        self.grid_region.clear();
        // Tools let go.
        self.grips.clear();
        self.contact_balls = state.contact_balls;
        self.last_contact_balls = state.last_contact_balls;
        self.rest_offsets = state.rest_offsets;
        self.fragments = state.fragments;
        self.bindings = state.bindings;
        self.needs_rebuild = state.needs_rebuild;
        self.steps = state.steps;
        self.is_nearly_whole = state.is_nearly_whole;
        self.paint = state.paint;
        self.replace_region(model, fixings, skin, system)
    }

    /// Constrains pinned nodes once more after a restore has put nodes where they were: away from rest, pins change what is held around them.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn restore_pins(&mut self, fixings: &[Fixing], nodes: &mut Nodes) -> Result<(), LatticeError> {
        if self.has_pins() {
            self.find_pinned(nodes);
            self.constrain(fixings, nodes)?;
        }
        Ok(())
    }
}
