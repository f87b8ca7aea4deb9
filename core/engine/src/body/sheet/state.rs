//! What of a sheet can be taken back.

use super::order::Order;
use super::{Edges, Sheet};
use crate::body::lattice::LatticeError;
use crate::body::model::Model;
use pliant_solver::{Nodes, System};
use std::collections::HashSet;
use std::sync::Arc;

/// A sheet at one moment; its large parts are shared until they change.
#[derive(Clone)]
pub struct SheetState {
    order: Arc<Order>,
    material: Arc<Vec<f64>>,
    clamped: Arc<Vec<[u32; 2]>>,
    driven: Vec<(u32, u32)>,
    active: bool,
}

impl Sheet {
    /// As it is now.
    pub fn save(&self) -> SheetState {
        SheetState {
            order: Arc::clone(&self.order),
            material: Arc::clone(&self.material),
            clamped: Arc::clone(&self.clamped),
            driven: self.driven.clone(),
            active: self.active,
        }
    }

    /// As it was, with these nodes, on a model that is as it was.
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
        let SheetState { order, material, clamped, driven, active } = state.clone();
        (self.order, self.material, self.clamped, self.driven, self.active) =
            (order, material, clamped, driven, active);
        self.cut = false;
        system.nodes.clone_from(nodes);
        if same || !self.active {
            return Ok(());
        }
        self.number(&model.surface);
        let triangles = self.triangles(&model.surface);
        let edges = self.edges(&triangles, &mut Nodes::at_rest(nodes.rest[..self.vertex_of.len()].to_vec()));
        self.list_elements(system, &triangles, edges)?;
        system.nodes.mass.clone_from(&nodes.mass);
        Ok(())
    }

    /// Edges of the mesh; the clamped ones are known.
    pub(super) fn edges(&self, triangles: &[[u32; 3]], nodes: &mut Nodes) -> Edges {
        let clamped: HashSet<[u32; 2]> = self.clamped.iter().copied().collect();
        Edges::new(triangles, |ends| clamped.contains(&self.vertices(ends)), nodes)
    }
}
