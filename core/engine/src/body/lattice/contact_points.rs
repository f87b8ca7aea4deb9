//! Points of the surface of a solid that contact with obstacles looks at, with the nodes that carry them.

use super::{Lattice, LatticeError};
use crate::body::{Model, Samples, Skin};
use pliant_solver::{Nodes, Vec3};

/// Longest edge of the surface, in edges of a cell, up to which its vertices stand for it; where edges are longer, samples do too.
const FINE: f64 = 0.5;

/// A point of the surface in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Nodes at the corners of the cell.
    pub nodes: [u32; 8],
    /// Trilinear weights of the nodes; they add up to 1.
    pub weights: [f64; 8],
    /// Present position, m.
    pub position: Vec3,
}

/// What [`Lattice::visit_contact_points`] reads and updates besides the lattice.
pub struct ContactSurface<'a> {
    /// The nodes of the body.
    pub nodes: &'a Nodes,
    /// Model of the body, whose vertices are the points.
    pub model: &'a Model,
    /// Positions of the vertices; those in the cell are updated where the grid is not linear.
    pub skin: &'a mut Skin,
    /// Samples of the surface.
    pub samples: &'a Samples,
    /// Buffers, kept from call to call.
    pub buffers: &'a mut ContactBuffers,
}

/// Weights and positions of the samples of a cell.
#[derive(Debug, Default)]
pub struct ContactBuffers {
    weights: Vec<[f64; 8]>,
    positions: Vec<Vec3>,
}

impl Lattice {
    /// The active cells that have a part of the surface.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn surface_cells(&self, samples: &Samples) -> Result<Vec<u32>, LatticeError> {
        let mut cells = Vec::new();
        for cell in 0..self.region.cell_id.len() as u32 {
            if !self.points(cell)?.is_empty() || !self.samples_of(samples, cell).is_empty() {
                cells.push(cell);
            }
        }
        Ok(cells)
    }

    /// Calls `visit` with each vertex of the surface in an active cell, the nodes at the corners of that cell and their trilinear weights.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn visit_vertices(
        &mut self,
        model: &Model,
        mut visit: impl FnMut(u32, &[u32; 8], &[f64; 8]),
    ) -> Result<(), LatticeError> {
        for cell in 0..self.region.cell_id.len() as u32 {
            let first = self.set_weights(cell, model)?;
            for (i, &v) in self.points(cell)?.iter().enumerate() {
                visit(v, &self.region.cell_corners[cell as usize], &self.weights[first + i]);
            }
        }
        Ok(())
    }

    /// Calls `visit` with the vertices in an active cell and, where edges are long or there is no vertex, with its samples. Positions follow from the
    /// trilinear weights, of which contact knows the derivative, also where the surface is smooth.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn visit_contact_points(
        &mut self,
        cell: u32,
        surface: &mut ContactSurface<'_>,
        mut visit: impl FnMut(ContactPoint),
    ) -> Result<(), LatticeError> {
        let ContactSurface { nodes, model, skin, samples, buffers } = surface;
        let corners = self.region.cell_corners[cell as usize];
        let first = self.set_weights(cell, model)?;
        let is_nonlinear = self.source.is_nonlinear();
        if is_nonlinear {
            self.embed_cell(cell, nodes, model, skin)?;
        }
        let moved = corners.map(|n| nodes.x[n as usize] - nodes.rest[n as usize]);
        for (i, &v) in self.points(cell)?.iter().enumerate().filter(|(_, v)| !self.is_loose(**v)) {
            let weights = self.weights[first + i];
            let position = match is_nonlinear {
                true => skin.x[v as usize],
                false => interpolate(skin.settled[v as usize], &weights, &moved),
            };
            visit(ContactPoint { nodes: corners, weights, position });
        }
        if self.longest_edge(cell) <= FINE * self.edge() && !self.points(cell)?.is_empty() {
            return Ok(());
        }
        let range = self.samples_of(samples, cell);
        let places = &samples.place[range];
        let ContactBuffers { weights, positions } = &mut **buffers;
        positions.clear();
        weights.clear();
        weights.resize(places.len(), [0.0; 8]);
        self.weights_in(cell, places, weights)?;
        if is_nonlinear {
            self.embed_places(cell, places, weights, nodes, positions)?;
        } else {
            let moved = self.displacements(cell, nodes);
            positions.extend(places.iter().zip(weights.iter()).map(|(place, w)| interpolate(*place, w, &moved)));
        }
        for (&weights, &position) in weights.iter().zip(positions.iter()) {
            visit(ContactPoint { nodes: corners, weights, position });
        }
        Ok(())
    }
}

/// A position (m) moved by displacements (m) of the corners of its cell with these weights.
fn interpolate(place: Vec3, weights: &[f64; 8], moved: &[Vec3; 8]) -> Vec3 {
    weights.iter().zip(moved).fold(place, |sum, (w, u)| sum + *w * *u)
}
