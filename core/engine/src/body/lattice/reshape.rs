//! Moving the shape a lattice has at rest.

use super::{Lattice, LatticeError};
use crate::body::model::Model;
use crate::body::reshape::RestChange;
use bytemuck::{cast_slice, cast_slice_mut};
use pliant_solver::Vec3;

impl Lattice {
    /// Surface points of an active cell and their weights at its corners, by point.
    ///
    /// # Errors
    /// What the grid says.
    pub fn weighted_points(&mut self, cell: u32, model: &Model) -> Result<(&[u32], &[[f64; 8]]), LatticeError> {
        let first = self.set_weights(cell, model)?;
        let points = self.points(cell)?;
        Ok((points, &self.weights[first..first + points.len()]))
    }

    /// Moves vertices of `settled` (m) by what the change of the nodes that carry them comes to, from `rest` (m); `moved` gets those
    /// that moved.
    ///
    /// # Errors
    /// What the grid says.
    pub(in crate::body) fn move_points(
        &mut self,
        change: &RestChange,
        rest: &[Vec3],
        model: &Model,
        settled: &mut [Vec3],
        moved: &mut Vec<u32>,
    ) -> Result<(), LatticeError> {
        let (mut by, near) = (Vec::new(), self.nodes_near(&change.nodes));
        for cell in 0..self.region.cell_id.len() as u32 {
            let corners = self.region.cell_corners[cell as usize];
            if corners.iter().all(|&n| !near[n as usize]) {
                continue;
            }
            if self.grid.is_nonlinear() {
                self.move_nonlinear(cell, change, rest, model, settled)?;
                moved.extend_from_slice(self.points(cell)?);
                continue;
            }
            by.clear();
            self.move_by(cell, &change.nodes, model, &mut by)?;
            for (&v, by) in self.points(cell)?.iter().zip(&by).filter(|(_, by)| **by != Vec3::zeros()) {
                settled[v as usize] += *by;
                moved.push(v);
            }
        }
        Ok(())
    }

    fn move_nonlinear(
        &self,
        cell: u32,
        change: &RestChange,
        rest: &[Vec3],
        model: &Model,
        settled: &mut [Vec3],
    ) -> Result<(), LatticeError> {
        let points = self.points(cell)?;
        let places: Vec<Vec3> = points.iter().map(|&v| model.surface.points[v as usize]).collect();
        let corners = self.region.cell_corners[cell as usize];
        let mut out = [vec![Vec3::zeros(); points.len()], vec![Vec3::zeros(); points.len()]];
        for (moves, out) in [0.0, 1.0].into_iter().zip(&mut out) {
            let at = corners.map(|n| rest[n as usize] + moves * change.nodes[n as usize]);
            let all = vec![at; points.len()];
            self.grid.place(self.settings.level, cast_slice(&places), cast_slice(&all), cast_slice_mut(out))?;
        }
        for (i, &v) in points.iter().enumerate() {
            settled[v as usize] += out[1][i] - out[0][i];
        }
        Ok(())
    }

    /// Nodes on which the surface depends where some nodes change: these, and those they share a cell with.
    fn nodes_near(&self, change: &[Vec3]) -> Vec<bool> {
        let mut near: Vec<bool> = change.iter().map(|d| *d != Vec3::zeros()).collect();
        if self.smooth.is_some() {
            let changed = near.clone();
            let cells = self.region.cell_corners.iter().filter(|corners| corners.iter().any(|n| changed[*n as usize]));
            cells.flatten().for_each(|n| near[*n as usize] = true);
        }
        near
    }

    /// Moves rest positions, for good.
    pub(in crate::body) fn move_rest(&mut self, change: &[Vec3], rest: &mut [Vec3]) {
        self.keep_slopes(|n| change[n as usize]);
        let near = self.nodes_near(change);
        for i in (0..rest.len()).filter(|i| near[*i]) {
            rest[i] += change[i];
            self.keep_node(i as u32, rest[i] - self.grid_rest(i as u32));
        }
    }
}
