//! Loads on places of a body, and how they change as the body moves there.

use super::sums::Sums;
use crate::body::{Body, Discretization, LatticeError};
use pliant_solver::{Block, NodeSprings, Nodes, Vec3};

/// Loads on rest places.
#[derive(Debug, Default)]
pub struct PlaceLoads {
    /// m, rest places (s x 3)
    pub places: Vec<Vec3>,
    /// Force, N (s x 3).
    pub force: Vec<Vec3>,
    /// Stiffness, N/m (s blocks).
    pub stiffness: Vec<Block>,
    /// Damping, N s/m (s blocks).
    pub damping: Vec<Block>,
    sums: Sums,
    weights: Vec<[f64; 8]>,
}

impl PlaceLoads {
    /// Removes all loads; keeps the buffers.
    pub fn clear(&mut self) {
        self.places.clear();
        self.force.clear();
        self.stiffness.clear();
        self.damping.clear();
    }

    /// Adds the load at one rest place.
    pub fn push(&mut self, place: Vec3, force: Vec3, stiffness: Block, damping: Block) {
        self.places.push(place);
        self.force.push(force);
        self.stiffness.push(stiffness);
        self.damping.push(damping);
    }

    /// Gives the loads to the nodes of a body, by the transpose of the embedding. Places beside the active cells are left out and the
    /// others take their share, so that the whole load arrives.
    ///
    /// # Errors
    /// A grid that fails.
    pub fn attach(&mut self, body: &mut Body, out: &mut NodeSprings) -> Result<(), LatticeError> {
        let Body { discretization, model, skin, system, .. } = body;
        let nodes = &system.nodes;
        let sums = &mut self.sums;
        sums.begin(nodes.len());
        let lattice = match discretization {
            Discretization::Lattice(lattice) => lattice,
            Discretization::Sheet(sheet) => {
                for (i, place) in self.places.iter().enumerate() {
                    let Some((triangle, bary)) = sheet.seat(*place, model, skin) else { continue };
                    for (node, weight) in sheet.nodes_of(model, triangle).into_iter().zip(bary.iter().copied()) {
                        sums.add(node, weight, self.force[i], &self.stiffness[i], &self.damping[i]);
                    }
                }
                self.give(nodes, out);
                return Ok(());
            }
        };
        if lattice.grid.is_nonlinear() {
            lattice.pull_back(&self.places, &self.force, nodes, |node, f| {
                let at = sums.touch(node).0;
                *at += f;
            })?;
        } else {
            let (force, stiffness, damping) = (&self.force, &self.stiffness, &self.damping);
            let mut weights = std::mem::take(&mut self.weights);
            lattice.stencils(&self.places, &mut weights, |place, node, weight| {
                sums.add(node, weight, force[place], &stiffness[place], &damping[place]);
            })?;
            self.weights = weights;
        }
        self.give(nodes, out);
        Ok(())
    }

    /// Scaled so that all of the load arrives.
    fn give(&mut self, nodes: &Nodes, out: &mut NodeSprings) {
        let (wanted, arrived) = (self.force.iter().sum::<Vec3>().norm(), self.sums.total().norm());
        self.sums.give(if arrived > 0.0 { wanted / arrived } else { 1.0 }, &nodes.x, out);
    }
}
