//! A body as the integrator sees it: nodes, elements and a material.

use super::algebra::Vec3;
use super::coupled::{CoupledHinges, is_coupled_hinges, par_planes};
use super::elements::ElementSet;
use super::elements::chunk::Chunk;
use super::matrix::Matrix;
use super::nodes::Nodes;
use super::normals::{NormalsEnergy, wants_normals};
use super::threads::{NODES, Pool};
use crate::force_model::{ForceError, ForceModel, StepTime};
use pliant_plugin_api::{PlanesMut, abi};

/// Nodes, elements and material of a body, with their matrix where a scheme needs one.
pub struct System {
    /// The nodes and their state.
    pub nodes: Nodes,
    /// Element sets, one for each request of the material.
    pub sets: Vec<ElementSet>,
    /// The force model.
    pub material: Box<dyn ForceModel>,
    /// The matrix; `None` until [`System::enable_matrix`].
    pub matrix: Option<Matrix>,
    /// Coupled hinges, if the material requests them.
    pub coupled: Option<CoupledHinges>,
    /// An energy of vertex normals, if the material has one.
    pub normals: Option<NormalsEnergy>,
}

/// The state of a body from which forces and matrices are computed.
#[derive(Clone, Copy)]
pub struct SystemState<'a> {
    /// The force model.
    pub material: &'a dyn ForceModel,
    /// Element sets, one for each request of the material.
    pub sets: &'a [ElementSet],
    /// Nodes with their positions and velocities.
    pub nodes: &'a Nodes,
    /// Time of the state and length of the step that begins there.
    pub time: StepTime,
}

impl System {
    /// A body without nodes.
    pub fn new(material: Box<dyn ForceModel>) -> Self {
        let is_whole = material.wants_whole_lists();
        let sets: Vec<_> = material.requests().iter().map(|r| ElementSet::new(*r, is_whole)).collect();
        let coupled = sets.iter().any(is_coupled_hinges).then(CoupledHinges::default);
        let normals = sets.iter().any(wants_normals).then(NormalsEnergy::default);
        Self { nodes: Nodes::default(), sets, material, matrix: None, coupled, normals }
    }

    /// The current state.
    pub fn state(&self, time: StepTime) -> SystemState<'_> {
        SystemState { material: &*self.material, sets: &self.sets, nodes: &self.nodes, time }
    }

    /// The current state and the coupled hinges, the arguments of [`Matrix::assemble`].
    pub fn assembly_parts(&mut self, time: StepTime) -> (SystemState<'_>, Option<&mut CoupledHinges>) {
        let Self { nodes, sets, material, coupled, .. } = self;
        (SystemState { material: &**material, sets, nodes, time }, coupled.as_mut())
    }

    /// Adds a matrix. Its pattern is rebuilt with the elements from now on.
    pub fn enable_matrix(&mut self) {
        let matrix = self.matrix.get_or_insert_default();
        matrix.rebuild(self.nodes.len(), &mut self.sets);
    }

    /// Sets the hinge of each triangle's sides 01, 12, 20, or `u32::MAX` for none (t x 3). Call [`System::prepare`] next.
    pub fn set_sides(&mut self, sides: Vec<[u32; 3]>) {
        if let Some(normals) = &mut self.normals {
            normals.sides.clone_from(&sides);
        }
        if let Some(coupled) = &mut self.coupled {
            coupled.sides = sides;
        }
    }

    /// Recomputes chunks, rest data, lumped masses and the pattern of the matrix; history becomes zero. Call it after nodes or lists of elements
    /// have changed.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn prepare(&mut self) -> Result<(), ForceError> {
        self.forget_element_warning();
        for set in &mut self.sets {
            set.prepare(&*self.material, &self.nodes)?;
        }
        self.lump_mass()?;
        if let Some(coupled) = &mut self.coupled {
            coupled.prepare(&*self.material, &self.sets, &self.nodes)?;
        }
        if let Some(normals) = &mut self.normals {
            normals.prepare(&*self.material, &self.sets, &self.nodes)?;
        }
        if let Some(matrix) = &mut self.matrix {
            matrix.rebuild(self.nodes.len(), &mut self.sets);
        }
        Ok(())
    }

    /// Has the material forget what was doubtful about elements, if there are some to be looked at anew.
    fn forget_element_warning(&self) {
        if self.sets.iter().any(|set| set.count() > 0) {
            self.material.forget_element_warning();
        }
    }

    /// Recomputes rest data. Call it after rest positions alone have changed.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn rest(&mut self) -> Result<(), ForceError> {
        self.forget_element_warning();
        self.sets.iter_mut().try_for_each(|set| set.rest(&*self.material, &self.nodes))
    }

    /// Recomputes rest data, and what the solver keeps of them. Call it after factors of the material's parameters alone have changed; shapes, masses and
    /// history stay.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn renew_rest(&mut self) -> Result<(), ForceError> {
        self.rest()?;
        if let Some(coupled) = &mut self.coupled {
            coupled.prepare(&*self.material, &self.sets, &self.nodes)?;
        }
        if let Some(normals) = &mut self.normals {
            normals.prepare(&*self.material, &self.sets, &self.nodes)?;
        }
        Ok(())
    }

    /// Recomputes rest data and lumped masses. Call it after factors of the material's parameters have changed that masses depend on; shapes and history
    /// stay.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn renew_parameters(&mut self) -> Result<(), ForceError> {
        self.renew_rest()?;
        self.lump_mass()
    }

    /// Recomputes the lumped masses.
    fn lump_mass(&mut self) -> Result<(), ForceError> {
        let mut mass = std::mem::take(&mut self.nodes.mass);
        mass.clear();
        mass.resize(self.nodes.len(), 0.0);
        for set in self.sets.iter().filter(|s| s.has(abi::HAS_MASS)) {
            for chunk in set.schedule.chunks() {
                set.add_mass(&*self.material, chunk, &self.nodes, &mut mass[chunk.window.clone()])?;
            }
        }
        self.nodes.mass = mass;
        Ok(())
    }

    /// Index of the first node without a finite mass above zero.
    pub fn massless(&self) -> Option<usize> {
        self.nodes.mass.iter().position(|m| !(m.is_finite() && *m > 0.0))
    }

    /// Computes `force = -dE/dx - C v`, N (n x 3), for velocities `v`, m/s (n x 3), by default those of the nodes.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn forces(
        &mut self,
        pool: &Pool,
        v: Option<&[Vec3]>,
        time: StepTime,
        force: &mut [Vec3],
    ) -> Result<(), ForceError> {
        self.forces_with_precision(pool, v, time, force, false)
    }

    /// As [`System::forces`], with moments of coupled hinges in single precision if `single`.
    ///
    /// # Errors
    /// As [`System::forces`].
    pub(super) fn forces_with_precision(
        &mut self,
        pool: &Pool,
        v: Option<&[Vec3]>,
        time: StepTime,
        force: &mut [Vec3],
        single: bool,
    ) -> Result<(), ForceError> {
        self.update_failed()?;
        let v = v.unwrap_or(&self.nodes.v);
        pool.par_chunks(&mut *force, NODES, &|_, force: &mut [Vec3]| force.fill(Vec3::zeros()));
        for set in self.sets.iter().filter(|s| s.has(abi::HAS_FORCES)) {
            set.schedule.run(pool, force, &|node| node, &|chunk, window| {
                set.for_each_intact(chunk, |chunk| {
                    let window = bytemuck::cast_slice_mut(&mut *window);
                    set.add_forces(&*self.material, chunk, &self.nodes, v, time, window)
                })
            })?;
        }
        let state = SystemState { material: &*self.material, sets: &self.sets, nodes: &self.nodes, time };
        if let Some(normals) = &mut self.normals {
            normals.forces(pool, state, force)?;
        }
        match &mut self.coupled {
            Some(coupled) => coupled.forces(pool, state, force, single),
            None => Ok(()),
        }
    }

    /// Elastic energy of the current state, J.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn energy(&mut self, time: StepTime) -> Result<f64, ForceError> {
        self.update_failed()?;
        let mut energy = 0.0;
        for set in self.sets.iter().filter(|s| s.has(abi::HAS_FORCES)) {
            for chunk in set.schedule.chunks() {
                set.for_each_intact(chunk, |chunk| {
                    energy += set.energy(&*self.material, chunk, &self.nodes, time)?;
                    Ok(())
                })?;
            }
        }
        let state = SystemState { material: &*self.material, sets: &self.sets, nodes: &self.nodes, time };
        if let Some(coupled) = &mut self.coupled {
            energy += coupled.energy(&Pool::new(1), state)?;
        }
        if let Some(normals) = &mut self.normals {
            energy += normals.energy(state)?;
        }
        Ok(energy)
    }

    /// Updates the history of elements, such as plastic strain, after an accepted step. If the material fails, all histories stay.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn advance(&mut self, pool: &Pool, time: StepTime) -> Result<(), ForceError> {
        self.update_failed()?;
        let has_history = |set: &&mut ElementSet| set.has(abi::HAS_HISTORY) && set.request().history_stride > 0;
        for set in self.sets.iter_mut().filter(has_history) {
            let mut next = std::mem::take(&mut set.next_history);
            next.copy_from_slice(&set.history);
            let planes = PlanesMut::new(&mut next, set.request().history_stride as usize);
            let result = par_planes(pool, set.halvings(pool), planes, &|planes| {
                let whole = Chunk { range: planes.range(), window: 0..self.nodes.len() };
                set.for_each_intact(&whole, |part| set.advance(&*self.material, part, &self.nodes, time, planes))
            });
            set.next_history = next;
            // After an error all histories are as before.
            result?;
        }
        for set in self.sets.iter_mut().filter(has_history) {
            std::mem::swap(&mut set.history, &mut set.next_history);
            set.failed_is_stale = true;
        }
        self.update_failed()
    }

    /// Has the material say which elements have failed, if histories have changed since it last did.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn update_failed(&mut self) -> Result<(), ForceError> {
        let Self { sets, material, nodes, .. } = self;
        sets.iter_mut().try_for_each(|set| set.update_failed(&**material, nodes))
    }

    /// Number of elements that have failed.
    pub fn failed_count(&self) -> usize {
        self.sets.iter().map(ElementSet::failed_count).sum()
    }

    /// Records the history of elements before a step that may be taken again.
    pub(super) fn keep_history(&mut self) {
        self.sets.iter_mut().for_each(|set| set.start_history.copy_from_slice(&set.history));
    }

    /// Exchanges the history of elements with the one that [`System::keep_history`] recorded.
    pub(super) fn swap_history(&mut self) {
        for set in &mut self.sets {
            std::mem::swap(&mut set.history, &mut set.start_history);
            set.failed_is_stale = true;
        }
    }

    /// Sets the history of all elements to zero.
    pub fn clear_history(&mut self) {
        for set in &mut self.sets {
            set.history.fill(0.0);
            set.failed_is_stale = true;
        }
    }

    /// Whether any element has damping.
    pub fn is_damped(&self) -> bool {
        self.sets.iter().any(|s| s.has(abi::HAS_DAMPING))
    }

    /// Number of elements that have forces.
    pub fn elements(&self) -> usize {
        self.sets.iter().filter(|s| s.has(abi::HAS_FORCES)).map(ElementSet::count).sum()
    }
}
