//! Changes of the rest shape of a lattice.

use super::{Lattice, LatticeError};
use crate::body::Moves;
use crate::body::model::Model;
use crate::body::reshape::RestChange;
use bytemuck::{cast_slice, cast_slice_mut};
use pliant_solver::Vec3;

impl Lattice {
    /// Surface points of an active cell (p), and their trilinear weights at its corners (p x 8).
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn weighted_points(&mut self, cell: u32, model: &Model) -> Result<(&[u32], &[[f64; 8]]), LatticeError> {
        let first = self.set_weights(cell, model)?;
        let points = self.points(cell)?;
        Ok((points, &self.weights[first..first + points.len()]))
    }

    /// Appends the vertices that a change of the nodes displaces, with their displacements (m), to `moves`. `rest` has the rest positions of the nodes
    /// before the change (m, n x 3).
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn move_points(
        &mut self,
        change: &RestChange,
        rest: &[Vec3],
        model: &Model,
        moves: &mut Moves,
    ) -> Result<(), LatticeError> {
        let (mut displacements, near) = (Vec::new(), self.nodes_near(&change.nodes));
        for cell in 0..self.region.cell_id.len() as u32 {
            let corners = self.region.cell_corners[cell as usize];
            if corners.iter().all(|&n| !near[n as usize]) {
                continue;
            }
            if self.source.is_nonlinear() {
                self.move_nonlinear(cell, change, rest, model, moves)?;
                continue;
            }
            displacements.clear();
            self.displace_points(cell, &change.nodes, model, &mut displacements)?;
            let each = self.points(cell)?.iter().copied().zip(displacements.iter().copied());
            moves.extend(each.filter(|(_, d)| *d != Vec3::zeros()));
        }
        Ok(())
    }

    /// [`Lattice::move_points`] for one cell of a grid whose embedding is not linear.
    fn move_nonlinear(
        &self,
        cell: u32,
        change: &RestChange,
        rest: &[Vec3],
        model: &Model,
        moves: &mut Moves,
    ) -> Result<(), LatticeError> {
        let Some(grid) = self.source.nonlinear() else { return Ok(()) };
        let points = self.points(cell)?;
        let places: Vec<Vec3> = points.iter().map(|&v| model.surface.points[v as usize]).collect();
        let corners = self.region.cell_corners[cell as usize];
        let mut out = [vec![Vec3::zeros(); points.len()], vec![Vec3::zeros(); points.len()]];
        for (factor, out) in [0.0, 1.0].into_iter().zip(&mut out) {
            let at = corners.map(|n| rest[n as usize] + factor * change.nodes[n as usize]);
            let all = vec![at; points.len()];
            grid.place(self.settings.level, cast_slice(&places), cast_slice(&all), cast_slice_mut(out))?;
        }
        moves.extend(points.iter().enumerate().map(|(i, &v)| (v, out[1][i] - out[0][i])));
        Ok(())
    }

    /// Whether the jet of each node changes (n) with a nodal displacement field `change` (m, n x 3): that of a node that moves and, in a
    /// smooth embedding, of those it shares a cell with.
    fn nodes_near(&self, change: &[Vec3]) -> Vec<bool> {
        let mut near: Vec<bool> = change.iter().map(|d| *d != Vec3::zeros()).collect();
        if self.smooth.is_some() {
            let changed = near.clone();
            let cells = self.region.cell_corners.iter().filter(|corners| corners.iter().any(|n| changed[*n as usize]));
            cells.flatten().for_each(|n| near[*n as usize] = true);
        }
        near
    }

    /// Adds `change` to the rest positions `rest` (m, n x 3), and stores the result for regions to come.
    pub(in crate::body) fn move_rest(&mut self, change: &[Vec3], rest: &mut [Vec3]) {
        self.add_rest_jets(|n| change[n as usize]);
        let near = self.nodes_near(change);
        for i in (0..rest.len()).filter(|i| near[*i]) {
            rest[i] += change[i];
            self.store_rest_offset(i as u32, rest[i] - self.grid_rest(i as u32));
        }
    }
}
