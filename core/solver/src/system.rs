//! A body as the step sees it: nodes, elements, and the material that joins them.

use super::algebra::Vec3;
use super::coupled::{Coupled, is_coupled_hinges};
use super::elements::ElementSet;
use super::matrix::Matrix;
use super::nodes::Nodes;
use super::normals::{Normals, wants_normals};
use super::threads::{NODES, Pool};
use crate::force_model::{ForceError, ForceModel, StepTime};
use pliant_plugin_api::abi;

/// Nodes, elements, material and, where something needs it, their matrix.
pub struct System {
    /// State.
    pub nodes: Nodes,
    /// One per request of the material.
    pub sets: Vec<ElementSet>,
    /// What the force is.
    pub material: Box<dyn ForceModel>,
    /// `None` until [`System::enable_matrix`].
    pub matrix: Option<Matrix>,
    /// Hinges that act on each other, where the material wants them.
    pub coupled: Option<Coupled>,
    /// An energy of vertex normals, where the material has one.
    pub normals: Option<Normals>,
}

impl System {
    /// No nodes yet.
    pub fn new(material: Box<dyn ForceModel>) -> Self {
        let sets = material.requests().iter().map(|r| ElementSet::new(*r)).collect();
        let sets: Vec<ElementSet> = sets;
        let coupled = sets.iter().any(is_coupled_hinges).then(Coupled::default);
        let normals = sets.iter().any(wants_normals).then(Normals::default);
        Self { nodes: Nodes::default(), sets, material, matrix: None, coupled, normals }
    }

    /// Keeps a matrix from now on.
    pub fn enable_matrix(&mut self) {
        let matrix = self.matrix.get_or_insert_default();
        matrix.rebuild(self.nodes.len(), &mut self.sets);
    }

    /// Tells the hinge of each triangle's sides, or `u32::MAX`; then comes [`System::prepare`].
    pub fn set_sides(&mut self, sides: Vec<[u32; 3]>) {
        if let Some(normals) = &mut self.normals {
            normals.sides.clone_from(&sides);
        }
        if let Some(coupled) = &mut self.coupled {
            coupled.sides = sides;
        }
    }

    /// After nodes or lists of elements have changed: cuts, rest data, masses and the matrix's pattern.
    ///
    /// # Errors
    /// What the material says; a node that an element needs but that has no mass.
    pub fn prepare(&mut self) -> Result<(), ForceError> {
        for set in &mut self.sets {
            set.prepare(&*self.material, &self.nodes)?;
        }
        self.weigh()?;
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

    /// After rest positions alone have changed.
    ///
    /// # Errors
    /// What the material says.
    pub fn rest(&mut self) -> Result<(), ForceError> {
        self.sets.iter_mut().try_for_each(|set| set.rest(&*self.material, &self.nodes))
    }

    fn weigh(&mut self) -> Result<(), ForceError> {
        let mut mass = std::mem::take(&mut self.nodes.mass);
        mass.clear();
        mass.resize(self.nodes.len(), 0.0);
        for set in self.sets.iter().filter(|s| s.has(abi::HAS_MASS)) {
            for chunk in set.schedule.chunks() {
                let call = set.call(chunk, &self.nodes, &self.nodes.v, StepTime::default());
                self.material.mass(&call, &mut mass[chunk.window.clone()])?;
            }
        }
        self.nodes.mass = mass;
        Ok(())
    }

    /// The first node without a finite mass above zero.
    pub fn massless(&self) -> Option<usize> {
        self.nodes.mass.iter().position(|m| !(m.is_finite() && *m > 0.0))
    }

    /// `force = -dE/dx - C v`, N (n x 3), for velocities `v`, by default those of the nodes.
    ///
    /// # Errors
    /// What the material says.
    pub fn forces(
        &mut self,
        pool: &Pool,
        v: Option<&[Vec3]>,
        time: StepTime,
        force: &mut [Vec3],
    ) -> Result<(), ForceError> {
        self.forces_rounded(pool, v, time, (force, false))
    }

    /// The same; if `rounded`, with moments of coupled hinges to six digits.
    ///
    /// # Errors
    /// As [`System::forces`].
    pub(super) fn forces_rounded(
        &mut self,
        pool: &Pool,
        v: Option<&[Vec3]>,
        time: StepTime,
        (force, rounded): (&mut [Vec3], bool),
    ) -> Result<(), ForceError> {
        let v = v.unwrap_or(&self.nodes.v);
        pool.pieces(&mut *force, NODES, &|_, force: &mut [Vec3]| force.fill(Vec3::zeros()));
        for set in self.sets.iter().filter(|s| s.has(abi::HAS_FORCES)) {
            set.schedule.run(pool, force, &|node| node, &|chunk, window| {
                self.material.forces(&set.call(chunk, &self.nodes, v, time), bytemuck::cast_slice_mut(window))
            })?;
        }
        if let Some(normals) = &mut self.normals {
            normals.forces(pool, &*self.material, (&self.sets, &self.nodes, time), force)?;
        }
        match (&mut self.coupled, self.sets.iter().find(|set| is_coupled_hinges(set))) {
            (Some(coupled), Some(set)) => {
                coupled.forces(pool, &*self.material, set, (&self.nodes, time), (force, rounded))
            }
            _ => Ok(()),
        }
    }

    /// Elastic energy, J.
    ///
    /// # Errors
    /// What the material says.
    pub fn energy(&mut self, time: StepTime) -> Result<f64, ForceError> {
        let mut energy = 0.0;
        for set in self.sets.iter().filter(|s| s.has(abi::HAS_FORCES)) {
            for chunk in set.schedule.chunks() {
                energy += self.material.energy(&set.call(chunk, &self.nodes, &self.nodes.v, time))?;
            }
        }
        if let (Some(coupled), Some(set)) = (&mut self.coupled, self.sets.iter().find(|set| is_coupled_hinges(set))) {
            energy += coupled.energy(&Pool::new(1), &*self.material, set, &self.nodes, time)?;
        }
        if let Some(normals) = &mut self.normals {
            energy += normals.energy(&*self.material, &self.sets, &self.nodes, time)?;
        }
        Ok(energy)
    }

    /// Brings history up to date after an accepted step.
    ///
    /// # Errors
    /// What the material says.
    pub fn advance(&mut self, time: StepTime) -> Result<(), ForceError> {
        for set in self.sets.iter_mut().filter(|s| s.has(abi::HAS_HISTORY)) {
            let mut next = std::mem::take(&mut set.next_history);
            next.copy_from_slice(&set.history);
            let done = set.schedule.chunks().try_for_each(|chunk| {
                self.material.advance(&set.call(chunk, &self.nodes, &self.nodes.v, time), &mut next)
            });
            set.next_history = std::mem::replace(&mut set.history, next);
            done?;
        }
        Ok(())
    }

    /// Whether any element has damping.
    pub fn is_damped(&self) -> bool {
        self.sets.iter().any(|s| s.has(abi::HAS_DAMPING))
    }

    /// Elements that have forces.
    pub fn elements(&self) -> usize {
        self.sets.iter().filter(|s| s.has(abi::HAS_FORCES)).map(ElementSet::count).sum()
    }
}
