//! Fibre directions of the elements of a lattice.
//!
//! All elements of a cell have the direction at its middle in the undeformed grid, so it does not depend on what is active. Where edits have moved the
//! shape at rest, fibres are lines of the material: the direction is mapped by the gradient of the rest positions at the middle of the cell, and has unit
//! length again, for the stretch of a fibre counts from the new shape at rest.

use super::Lattice;
use pliant_plugin_api::abi;
use pliant_solver::{System, Vec3};

impl Lattice {
    /// Gives the elements listed last their fibre directions, if they want any and the body has fibres.
    pub(in crate::body) fn list_directions(&mut self, system: &mut System) {
        let Some(fibres) = self.fibres.clone() else { return };
        let wants = |set: &&mut pliant_solver::ElementSet| set.has(abi::WANTS_DIRECTIONS);
        if system.sets.iter_mut().find(wants).is_none() {
            return;
        }
        let half = Vec3::repeat(0.5 * self.facts.edge);
        let mut cells: Vec<[f64; 3]> = Vec::with_capacity(self.region.cell_id.len());
        for (id, corners) in self.region.cell_id.iter().zip(&self.region.cell_corners) {
            let middle = self.grid_rest(corners[0]) + half;
            let direction = *self.direction_of_cell.entry(*id).or_insert_with(|| fibres.at(middle));
            cells.push(self.follow_rest(direction, corners, &system.nodes.rest).into());
        }
        for set in system.sets.iter_mut().filter(wants) {
            let list = set.list_mut();
            let elements = list.nodes.len() / 4 / cells.len().max(1);
            list.directions.clear();
            list.directions.extend(cells.iter().flat_map(|cell| std::iter::repeat_n(*cell, elements)));
        }
    }

    /// The direction of a line of the material in a cell whose corners have moved to `rest` (m).
    fn follow_rest(&self, direction: Vec3, corners: &[u32; 8], rest: &[Vec3]) -> Vec3 {
        let moved = |corner: usize| rest[corners[corner] as usize] - self.grid_rest(corners[corner]);
        let displacements: [Vec3; 8] = std::array::from_fn(moved);
        if displacements.iter().all(|d| *d == Vec3::zeros()) {
            return direction;
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
