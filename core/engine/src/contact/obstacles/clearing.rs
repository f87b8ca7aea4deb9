//! Moves out of obstacles what is inside of them after a step all the same.

use super::ObstacleContacts;
use crate::body::{Body, Discretization, LatticeError};
use crate::obstacle::Nearest;
use pliant_solver::System;

/// Largest depth, in edges of a cell, from which a drawn vertex is moved out.
const DRAWN: f64 = 0.25;
/// Number of times that points which are inside after a step are moved out; one move may bring another point in.
const MAX_CORRECTIONS: usize = 8;

impl ObstacleContacts {
    /// Moves the points out that are deeper in an obstacle after the substep than before it, and takes their velocity inwards.
    pub(super) fn move_out(&mut self, system: &mut System) {
        for _ in 0..MAX_CORRECTIONS {
            let mut is_done = true;
            for at in 0..self.points.len() {
                let point = &self.points[at];
                let index = point.obstacle as usize;
                let placed = &self.obstacles[index];
                let x = point.position(&system.nodes);
                let now = placed.nearest_after(x, self.dt);
                let excess = self.starts[at].1.min(0.0) - now.distance;
                let free = point.carriers().filter(|(node, _)| !self.fixed[*node as usize]);
                let squares: f64 = free.clone().map(|(_, w)| w * w).sum();
                if excess <= self.tolerance || squares == 0.0 {
                    continue;
                }
                is_done = false;
                let inwards = (point.mean(|i| system.nodes.v[i]) - placed.velocity_at(x)).dot(&now.normal).min(0.0);
                for (node, weight) in free {
                    let (i, share) = (node as usize, weight / squares);
                    system.nodes.x[i] += share * excess * now.normal;
                    system.nodes.v[i] -= share * inwards * now.normal;
                    self.force[index] += system.nodes.mass[i] / self.span * share * inwards * now.normal;
                }
            }
            if is_done {
                break;
            }
        }
    }

    /// Moves vertices of a solid that is drawn smoothly out of obstacles: contact knows the weights of the grid, from which the smooth surface differs by
    /// a few hundredths of a cell, and more in a crash. What is deeper than a quarter of a cell is no matter of drawing and stays.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn clear_skin(&self, body: &mut Body) -> Result<(), LatticeError> {
        let Body { discretization: Discretization::Lattice(lattice), skin, .. } = body else { return Ok(()) };
        for &(obstacle, cell) in self.candidates.near() {
            let placed = &self.obstacles[obstacle as usize];
            for &v in lattice.points(cell)? {
                let Nearest { distance, normal } = placed.nearest(skin.x[v as usize]);
                if distance < 0.0 && distance > -DRAWN * lattice.edge() {
                    skin.x[v as usize] -= distance * normal;
                    skin.pages.mark(v);
                }
            }
        }
        Ok(())
    }
}
