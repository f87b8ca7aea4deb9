//! The soft region of an edit: the nodes around a place, weighted by a falloff of their distance.
//!
//! A node belongs to the region if its distance from the centre, in the rest shape, is at most the radius and a path through the material
//! within the ball connects it to the centre: an adjacent finger or the opposite wall of a slit is excluded. The load of an edit is a body
//! force with the density `falloff(r / radius)`, so it does not depend on the resolution of the grid, and the displacement is as smooth as
//! that of a regularised point load (de Goes and James 2017).

use super::key::DEFAULT_RADIUS;
use crate::body::{Body, Discretization, Lattice, LatticeError};
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::{Nodes, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;

/// Weight of an edit as a function of `r`, the distance over the radius: 1 at `r = 0`, 0 beyond `r = 1`.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Falloff {
    /// `(1 - r)^2 (1 + 2 r)`: its slope is zero at the centre and at the radius.
    #[default]
    Smooth,
    /// `sqrt(1 - r^2)`: the contact pressure of a ball (Hertz 1881).
    Sphere,
    /// `sqrt(1 - r)`
    Root,
    /// `(1 - r)^2`
    Sharp,
    /// `1 - r`
    Linear,
    /// 1 up to the radius.
    Constant,
}

impl Falloff {
    /// Every falloff, in the order of their numbers in recordings.
    pub const ALL: [Self; 6] = [Self::Smooth, Self::Sphere, Self::Root, Self::Sharp, Self::Linear, Self::Constant];

    /// Weight, 0 to 1, at a distance of `r` radii; 0 for `r >= 1`.
    pub fn weight(self, r: f64) -> f64 {
        if r >= 1.0 {
            return 0.0;
        }
        let p = 1.0 - r;
        match self {
            Self::Smooth => p * p * (1.0 + 2.0 * r),
            Self::Sphere => (1.0 - r * r).sqrt(),
            Self::Root => p.sqrt(),
            Self::Sharp => p * p,
            Self::Linear => p,
            Self::Constant => 1.0,
        }
    }
}

/// The size and profile of a soft region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrushShape {
    /// Radius, m, before the minimum of [`BrushShape::radius_at`].
    pub radius: f64,
    /// Weight by distance.
    pub falloff: Falloff,
}

/// Smallest radius of a region, in cell edges: below it the weights of nodes depend more on the grid than on the edit.
pub(crate) const MIN_RADIUS_EDGES: f64 = 1.5;

impl BrushShape {
    /// The shape of an edit with a tool.
    pub fn of(edit: &Edit, tool: &Tool) -> Self {
        let radius = edit.radius.unwrap_or(DEFAULT_RADIUS * tool.proxy.radius());
        Self { radius, falloff: edit.falloff }
    }

    /// The radius on a body with this cell edge, at least 1.5 edges; both in m.
    pub fn radius_at(&self, edge: f64) -> f64 {
        self.radius.max(MIN_RADIUS_EDGES * edge)
    }
}

/// Nodes of a body and their weights.
#[derive(Debug, Default)]
pub struct Brush {
    /// Indices, ascending (k).
    pub nodes: Vec<u32>,
    /// Falloff at each node, 0 to 1 (k).
    pub weight: Vec<f64>,
    /// Fraction of the load at each node, falloff times mass; they add up to 1 (k).
    pub fraction: Vec<f64>,
    /// Nodes within the radius and their distances, m (buffer).
    near: Vec<(u32, f64)>,
}

impl Brush {
    /// Selects the free nodes of `body` around `centre` (m) in the rest shape.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn cover(&mut self, body: &Body, centre: Vec3, shape: BrushShape) -> Result<(), LatticeError> {
        let radius = shape.radius_at(body.discretization.edge());
        body.nodes_within(centre, radius, &mut self.near)?;
        self.nodes.clear();
        self.weight.clear();
        self.fraction.clear();
        let nodes = &body.system.nodes;
        for &(node, distance) in &self.near {
            let weight = shape.falloff.weight(distance / radius);
            if weight > 0.0 && nodes.constraint[node as usize].is_free() {
                self.nodes.push(node);
                self.weight.push(weight);
                self.fraction.push(weight * nodes.mass[node as usize]);
            }
        }
        self.normalize_fractions();
        Ok(())
    }

    /// Replaces the weights, one for each node (k).
    pub fn set_weights(&mut self, weights: impl Iterator<Item = f64>, nodes: &Nodes) {
        self.weight.clear();
        self.weight.extend(weights);
        let loads = self.nodes.iter().zip(&self.weight).map(|(&n, weight)| weight * nodes.mass[n as usize]);
        self.fraction.clear();
        self.fraction.extend(loads);
        self.normalize_fractions();
    }

    fn normalize_fractions(&mut self) {
        let total: f64 = self.fraction.iter().sum();
        self.fraction.iter_mut().for_each(|fraction| *fraction /= total);
    }

    /// Active cells that have a node of the region.
    pub fn cells(&self, lattice: &Lattice) -> Vec<u32> {
        let covered = |corners: &[u32; 8]| corners.iter().any(|n| self.nodes.binary_search(n).is_ok());
        let cells = lattice.region().cell_corners.iter().enumerate();
        cells.filter(|(_, corners)| covered(corners)).map(|(cell, _)| cell as u32).collect()
    }

    /// Surface vertices embedded in the region within `radius` of `centre` (both in m, in the rest shape), ascending, with their falloff.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn vertices(
        &self,
        body: &Body,
        centre: Vec3,
        radius: f64,
        falloff: Falloff,
    ) -> Result<Vec<(u32, f64)>, LatticeError> {
        let mut vertices: Vec<u32> = Vec::new();
        match &body.discretization {
            Discretization::Sheet(sheet) => vertices.extend(self.nodes.iter().filter_map(|n| sheet.vertex_of(*n))),
            Discretization::Lattice(lattice) => {
                for cell in self.cells(lattice) {
                    vertices.extend_from_slice(lattice.points(cell)?);
                }
            }
        }
        vertices.sort_unstable();
        let weight = |v: u32| falloff.weight((body.skin.settled[v as usize] - centre).norm() / radius);
        Ok(vertices.into_iter().map(|v| (v, weight(v))).filter(|(_, weight)| *weight > 0.0).collect())
    }

    /// Whether it has no nodes.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Removes all nodes.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.weight.clear();
        self.fraction.clear();
    }

    /// Mean of a field (n x 3), weighted by the load fractions, in the unit of the field.
    pub fn mean(&self, field: &[Vec3]) -> Vec3 {
        self.nodes.iter().zip(&self.fraction).map(|(&n, fraction)| *fraction * field[n as usize]).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_falloff_decreases_from_one_at_the_centre_to_zero_at_the_radius() {
        for falloff in Falloff::ALL {
            assert_eq!(falloff.weight(0.0), 1.0, "{falloff:?}");
            assert_eq!((falloff.weight(1.0), falloff.weight(7.0)), (0.0, 0.0), "{falloff:?}");
            let weights: Vec<f64> = (0..=100).map(|i| falloff.weight(f64::from(i) / 100.0)).collect();
            assert!(weights.windows(2).all(|w| w[0] >= w[1]), "{falloff:?}");
        }
    }

    #[test]
    fn the_smooth_falloff_has_zero_slope_at_both_ends() {
        let slope = |r: f64| (Falloff::Smooth.weight(r + 1e-6) - Falloff::Smooth.weight(r - 1e-6)) / 2e-6;
        assert!(slope(1e-6).abs() < 1e-4 && slope(1.0 - 1e-6).abs() < 1e-4);
    }
}
