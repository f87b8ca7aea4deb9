//! What of a body can be taken back: its shape, its motion, and the cuts through it.

use super::lattice::LatticeState;
use super::{Body, LatticeError};
use crate::step::{Nodes, V3};
use std::sync::Arc;

/// A body at one moment.
#[derive(Clone)]
pub struct BodyState {
    nodes: Nodes,
    /// Of each set of elements.
    history: Vec<Vec<f64>>,
    lattice: LatticeState,
    settled: Arc<Vec<V3>>,
    /// Advances of a blade.
    cuts: usize,
    frozen: Option<String>,
}

impl Body {
    /// As it is now.
    pub fn save(&self) -> BodyState {
        BodyState {
            nodes: self.system.nodes.clone(),
            history: self.system.sets.iter().map(|set| set.history().to_vec()).collect(),
            lattice: self.lattice.save(),
            settled: Arc::clone(&self.skin.settled),
            cuts: self.cut.as_ref().map_or(0, |mesh| mesh.depth()),
            frozen: self.frozen.clone(),
        }
    }

    /// As it was.
    ///
    /// # Errors
    /// What grid or material say.
    pub fn restore(&mut self, state: &BodyState) -> Result<(), LatticeError> {
        let mut moved = Vec::new();
        let known = self.model.surface.triangles.len();
        if let Some(mesh) = &mut self.cut {
            while mesh.depth() > state.cuts && mesh.undo().is_some() {}
            while mesh.depth() < state.cuts && mesh.redo().is_some() {}
            let pairs = self.model.surface.triangles.iter().zip(&mesh.surface().triangles);
            moved = pairs.enumerate().filter(|(_, (a, b))| a != b).map(|(t, _)| t as u32).collect();
            self.model.take_cut(mesh.surface(), &moved);
        }
        let count = self.model.surface.triangles.len();
        moved.extend(known as u32..count as u32);
        let pairs = self.skin.settled.iter().zip(state.settled.iter()).enumerate();
        for (vertex, _) in pairs.filter(|(_, (a, b))| a != b) {
            moved.extend_from_slice(self.model.around(vertex as u32));
        }
        moved.sort_unstable();
        moved.dedup();
        self.skin.take_cut(&self.model, Arc::clone(&state.settled), &moved, count as u32..known.max(count) as u32);
        self.skin.settle();
        self.lattice.restore(&state.lattice, &self.model, &self.fixings, &mut self.skin, &mut self.system)?;
        self.system.nodes.x.clone_from(&state.nodes.x);
        self.system.nodes.v.clone_from(&state.nodes.v);
        self.system.nodes.prescribed.clone_from(&state.nodes.prescribed);
        for (set, history) in self.system.sets.iter_mut().zip(&state.history) {
            set.set_history(history);
        }
        self.frozen.clone_from(&state.frozen);
        if !self.samples.is_empty()
            && let Some(samples) = Arc::get_mut(&mut self.samples)
        {
            let cells: Vec<u64> = self.lattice.cut_cells().collect();
            samples.mend();
            samples.take_cut(&cells, &self.model, &self.skin, &self.lattice)?;
        }
        Ok(())
    }
}
