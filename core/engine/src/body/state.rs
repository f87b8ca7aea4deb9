//! State of a body for undo and snapshots: its shape, its motion, and the cuts through it.

use super::lattice::LatticeState;
use super::sheet::SheetState;
use super::symmetry::SymmetryState;
use super::{Body, Discretization, LatticeError, Symmetry};
use pliant_solver::{Nodes, Pool, Vec3};
use std::sync::Arc;

/// Saved state of a body.
#[derive(Clone)]
pub struct BodyState {
    pub(super) nodes: Nodes,
    /// History variables of each element set.
    pub(super) history: Vec<Vec<f64>>,
    pub(super) discretization: DiscretizationState,
    pub(super) settled: Arc<Vec<Vec3>>,
    /// Number of advances of blades that the mesh had taken.
    pub(super) cuts: usize,
    pub(super) frozen: Option<String>,
    pub(super) symmetry: Option<SymmetryState>,
}

#[derive(Clone)]
pub(super) enum DiscretizationState {
    Lattice(Box<LatticeState>),
    Sheet(SheetState),
}

impl BodyState {
    /// Whether history variables of the elements of `body` differ from those saved; a history of zeros equals none.
    pub fn has_other_history(&self, body: &Body) -> bool {
        let is_blank = |history: &[f64]| history.iter().all(|value| *value == 0.0);
        let differs = |(then, now): (&Vec<f64>, &[f64])| then != now && !(is_blank(then) && is_blank(now));
        self.history.iter().zip(body.system.sets.iter().map(|set| set.history())).any(differs)
    }
}

impl Body {
    /// Saves the state.
    pub fn save(&self) -> BodyState {
        BodyState {
            nodes: self.system.nodes.clone(),
            history: self.system.sets.iter().map(|set| set.history().to_vec()).collect(),
            discretization: match &self.discretization {
                Discretization::Lattice(lattice) => DiscretizationState::Lattice(Box::new(lattice.save())),
                Discretization::Sheet(sheet) => DiscretizationState::Sheet(sheet.save()),
            },
            settled: match self.failed_triangles.exposed().first_vertex() {
                Some(first) => Arc::new(self.skin.settled[..first as usize].to_vec()),
                None => Arc::clone(&self.skin.settled),
            },
            cuts: self.cut.as_ref().map_or(0, |mesh| mesh.depth()),
            frozen: self.frozen.clone(),
            symmetry: self.symmetry.as_ref().map(Symmetry::save),
        }
    }

    /// Restores which vertices are mirror images of each other, after [`Body::restore`].
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(crate) fn restore_symmetry(&mut self, state: &BodyState, pool: &Pool) -> Result<(), LatticeError> {
        if self.symmetry.is_none() {
            return Ok(());
        }
        self.embed_skin(pool)?;
        if let Some(symmetry) = &mut self.symmetry {
            symmetry.restore(state.symmetry.as_ref(), &self.model, &self.skin);
        }
        Ok(())
    }

    /// Restores a saved state of this body; the mesh undoes or redoes cuts until it has as many as then.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn restore(&mut self, state: &BodyState) -> Result<(), LatticeError> {
        // They follow from histories.
        self.withdraw_exposed_faces();
        let mut moved = Vec::new();
        let known = self.model.surface.triangles.len();
        if let Some(mesh) = &mut self.cut {
            while mesh.depth() > state.cuts && mesh.undo() {}
            while mesh.depth() < state.cuts && mesh.redo() {}
            let pairs = self.model.surface.triangles.iter().zip(&mesh.surface().triangles);
            moved = pairs.enumerate().filter(|(_, (a, b))| a != b).map(|(t, _)| t as u32).collect();
            Arc::make_mut(&mut self.model).take_cut(mesh.surface(), &moved);
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
        match (&mut self.discretization, &state.discretization) {
            (Discretization::Lattice(lattice), DiscretizationState::Lattice(state)) => {
                lattice.restore(state, &self.model, &self.fixings, &mut self.skin, &mut self.system)?;
            }
            (Discretization::Sheet(sheet), DiscretizationState::Sheet(of_sheet)) => {
                sheet.restore(of_sheet, &state.nodes, &self.model, &mut self.system)?;
            }
            // A body never changes its discretization.
            (Discretization::Lattice(_), DiscretizationState::Sheet(_))
            | (Discretization::Sheet(_), DiscretizationState::Lattice(_)) => {}
        }
        self.system.nodes.rest.clone_from(&state.nodes.rest);
        self.system.nodes.x.clone_from(&state.nodes.x);
        self.system.nodes.v.clone_from(&state.nodes.v);
        if let Discretization::Lattice(lattice) = &mut self.discretization {
            lattice.restore_pins(&self.fixings, &mut self.system.nodes)?;
        }
        self.system.nodes.prescribed.clone_from(&state.nodes.prescribed);
        for (set, history) in self.system.sets.iter_mut().zip(&state.history) {
            set.set_history(history);
        }
        self.system.update_failed()?;
        self.update_failed_triangles()?;
        self.frozen.clone_from(&state.frozen);
        self.update_tints()?;
        if !self.samples.is_empty() {
            let samples = Arc::make_mut(&mut self.samples);
            samples.forget_cuts();
            if let Some(lattice) = self.discretization.lattice() {
                let cells: Vec<u64> = lattice.cut_cells().collect();
                samples.take_cut(&cells, &self.model, &self.skin, lattice)?;
            }
        }
        Ok(())
    }
}
