//! Saved state of a sheet, for undo and snapshots.

use super::order::Order;
use super::paint::SheetPaint;
use super::{Edges, Sheet};
use crate::body::lattice::{DrivenNode, LatticeError};
use crate::body::model::Model;
use pliant_solver::{Nodes, System};
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

/// Saved state of a sheet without its nodes; large arrays are shared until they change. Fields are those of [`Sheet`].
#[derive(Clone)]
pub struct SheetState {
    pub(super) order: Arc<Order>,
    pub(super) material: Arc<Vec<f64>>,
    pub(super) clamped: Arc<Vec<[u32; 2]>>,
    pub(super) driven: Vec<DrivenNode>,
    pub(super) active: bool,
    pub(super) paint: SheetPaint,
    pub(super) welds: Arc<BTreeMap<u32, u32>>,
}

impl Sheet {
    /// Saves the state.
    pub fn save(&self) -> SheetState {
        SheetState {
            order: Arc::clone(&self.order),
            material: Arc::clone(&self.material),
            clamped: Arc::clone(&self.clamped),
            driven: self.driven.clone(),
            active: self.active,
            paint: self.paint.clone(),
            welds: Arc::clone(&self.welds),
        }
    }

    /// Restores a saved state, with the nodes saved with it. The model must have been restored before.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn restore(
        &mut self,
        state: &SheetState,
        nodes: &Nodes,
        model: &Model,
        system: &mut System,
    ) -> Result<(), LatticeError> {
        let same = Arc::ptr_eq(&self.material, &state.material) && system.nodes.rest == nodes.rest;
        let SheetState { order, material, clamped, driven, active, paint, welds } = state.clone();
        let same = same && self.welds == welds;
        let same_factors = Arc::ptr_eq(&self.paint.factors, &paint.factors);
        (self.order, self.material, self.clamped, self.driven, self.active) =
            (order, material, clamped, driven, active);
        (self.paint, self.welds) = (paint, welds);
        self.has_changed = false;
        system.nodes.clone_from(nodes);
        if !self.active || same && same_factors {
            return Ok(());
        }
        if same {
            self.renew_parameters(model, system)?;
            system.nodes.mass.clone_from(&nodes.mass);
            return Ok(());
        }
        self.number(&model.surface);
        let triangles = self.triangles(&model.surface);
        let edges = self.edges(&triangles, &mut Nodes::at_rest(nodes.rest[..self.vertex_of.len()].to_vec()));
        self.list_elements(system, &triangles, edges)?;
        system.nodes.mass.clone_from(&nodes.mass);
        Ok(())
    }

    /// Edges of the mesh; those in `self.clamped` are clamped.
    pub(super) fn edges(&self, triangles: &[[u32; 3]], nodes: &mut Nodes) -> Edges {
        let clamped: HashSet<[u32; 2]> = self.clamped.iter().copied().collect();
        Edges::new(triangles, |ends| clamped.contains(&self.vertices(ends)), nodes)
    }
}
