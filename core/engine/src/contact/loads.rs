//! Loads at points of a body and their linearisation.

use super::sums::NodeSums;
use crate::body::{Body, Discretization, LatticeError};
use pliant_solver::{Block, NodeSprings, Nodes, Vec3};

/// Loads at points of the rest shape.
#[derive(Debug, Default)]
pub struct PointLoads {
    /// Rest positions of the points, m (s x 3).
    pub points: Vec<Vec3>,
    /// Force, N (s x 3).
    pub force: Vec<Vec3>,
    /// Negative derivative of each force by the point's position, N/m (s blocks).
    pub stiffness: Vec<Block>,
    /// Negative derivative of each force by the point's velocity, N s/m (s blocks).
    pub damping: Vec<Block>,
    sums: NodeSums,
    cells: Vec<Option<u32>>,
    weights: Vec<[f64; 8]>,
}

impl PointLoads {
    /// Removes all loads and keeps the buffers.
    pub fn clear(&mut self) {
        self.points.clear();
        self.force.clear();
        self.stiffness.clear();
        self.damping.clear();
    }

    /// Adds the load at one rest position: force (N), stiffness (N/m), damping (N s/m).
    pub fn push(&mut self, point: Vec3, force: Vec3, stiffness: Block, damping: Block) {
        self.points.push(point);
        self.force.push(force);
        self.stiffness.push(stiffness);
        self.damping.push(damping);
    }

    /// Distributes the loads to the nodes of a body by the transpose of the embedding. Points outside of the active cells are left out and the
    /// forces at the others scaled so that the magnitude of the total force is kept.
    /// Stiffness and damping, which model how a load changes within a step, go to the diagonals of the same nodes.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn attach(&mut self, body: &mut Body, out: &mut NodeSprings) -> Result<(), LatticeError> {
        let Body { discretization, model, skin, system, .. } = body;
        let nodes = &system.nodes;
        let sums = &mut self.sums;
        sums.begin(nodes.len());
        let lattice = match discretization {
            Discretization::Lattice(lattice) => lattice,
            Discretization::Sheet(sheet) => {
                for (i, point) in self.points.iter().enumerate() {
                    let Some(nearest) = sheet.nearest_triangle(*point, model, skin) else { continue };
                    let corners = sheet.nodes_of(model, nearest.triangle);
                    for (node, weight) in corners.into_iter().zip(nearest.bary.iter().copied()) {
                        sums.add(node, weight, self.force[i], &self.stiffness[i], &self.damping[i]);
                    }
                }
                self.write(nodes, out);
                return Ok(());
            }
        };
        if lattice.source.is_nonlinear() {
            lattice.pull_back(&self.points, &self.force, nodes, |node, f| {
                let at = sums.entry(node).0;
                *at += f;
            })?;
        } else {
            lattice.find(&self.points, &mut self.cells, &mut self.weights)?;
            for (i, cell) in self.cells.iter().enumerate() {
                let Some(cell) = cell else { continue };
                lattice.visit_stiffness_shares(*cell, &self.weights[i], |node, share| {
                    sums.add_springs(node, share, &self.stiffness[i], &self.damping[i]);
                });
            }
            lattice.distribute_forces(&self.cells, &self.weights, &self.force, |node, f| *sums.entry(node).0 += f);
        }
        self.write(nodes, out);
        Ok(())
    }

    /// Moves the sums to `out`, with forces scaled so that the magnitude of the total force is that of all loads.
    fn write(&mut self, nodes: &Nodes, out: &mut NodeSprings) {
        let (total, distributed) = (self.force.iter().sum::<Vec3>().norm(), self.sums.total().norm());
        self.sums.drain_into(if distributed > 0.0 { total / distributed } else { 1.0 }, &nodes.x, out);
    }
}
