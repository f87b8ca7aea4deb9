//! Fibre directions of the elements of a lattice.
//!
//! All elements of a cell have the direction at its middle in the undeformed grid, so it does not depend on what is active. Where edits have moved the
//! shape at rest, fibres are lines of the material: the direction is mapped by the gradient of the rest positions at the middle of the cell, and has unit
//! length again, for the stretch of a fibre counts from the new shape at rest.

use super::Lattice;
use super::deformation::gradient_of_tetrahedron;
use super::fields::cells_of_tetrahedra;
use crate::body::fibres::Fibres;
use pliant_plugin_api::abi;
use pliant_solver::{System, Vec3};
use std::sync::Arc;

impl Lattice {
    /// Gives the body other fibres, from the next region on, and returns those it had.
    pub fn replace_fibres(&mut self, fibres: Option<Arc<Fibres>>) -> Option<Arc<Fibres>> {
        self.direction_of_cell.clear();
        std::mem::replace(&mut self.fibres, fibres)
    }

    /// Gives the elements listed last their fibre directions, if they want any and the body has fibres.
    pub(in crate::body) fn list_directions(&mut self, system: &mut System) {
        let Some(fibres) = self.fibres.clone() else { return };
        let wants = |set: &&mut pliant_solver::ElementSet| set.has(abi::WANTS_DIRECTIONS);
        if system.sets.iter_mut().find(wants).is_none() {
            return;
        }
        let middles: Vec<Vec3> = (0..self.region.cell_id.len() as u32).map(|cell| self.cell_centre(cell)).collect();
        let mut cells: Vec<[f64; 3]> = Vec::with_capacity(middles.len());
        for ((id, corners), middle) in self.region.cell_id.iter().zip(&self.region.cell_corners).zip(middles) {
            let direction = *self.direction_of_cell.entry(*id).or_insert_with(|| fibres.at(middle));
            cells.push(self.follow_rest(direction, corners, &system.nodes.rest).into());
        }
        for set in system.sets.iter_mut().filter(wants) {
            let list = set.list_mut();
            let of_elements: Vec<[f64; 3]> = cells_of_tetrahedra(list, cells.len()).map(|cell| cells[cell]).collect();
            list.directions = of_elements;
        }
    }

    /// The direction of a line of the material in a cell whose corners have moved to `rest` (m).
    fn follow_rest(&self, direction: Vec3, corners: &[u32; 8], rest: &[Vec3]) -> Vec3 {
        let moved = |corner: usize| rest[corners[corner] as usize] - self.grid_rest(corners[corner]);
        let displacements: [Vec3; 8] = std::array::from_fn(moved);
        if displacements.iter().all(|d| *d == Vec3::zeros()) {
            return direction;
        }
        if self.source.plugin().is_none() {
            let [a, b, c, d] = [0, 1, 2, 3].map(|corner| (self.grid_rest(corners[corner]), displacements[corner]));
            let mapped = gradient_of_tetrahedron([a.0, b.0, c.0, d.0], [a.1, b.1, c.1, d.1]) * direction;
            return mapped.try_normalize(f64::MIN_POSITIVE).unwrap_or(direction);
        }
        let mut mapped = direction;
        for axis in 0..3 {
            let ends = (0..8).filter(|corner| corner >> axis & 1 == 0);
            let sum: Vec3 = ends.map(|corner| displacements[corner | 1 << axis] - displacements[corner]).sum();
            mapped += direction[axis] / (4.0 * self.facts.edge) * sum;
        }
        mapped.try_normalize(f64::MIN_POSITIVE).unwrap_or(direction)
    }
}
