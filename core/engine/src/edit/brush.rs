//! The soft region of an edit: the nodes around a place, weighted by a falloff of their distance.
//!
//! A node belongs to the region if its distance from the centre, in the shape the body has at rest, is within the radius and the
//! material between them leads to it without leaving the ball: a neighbouring finger or the other wall of a slit stays out.
//! The load of an edit is a body force with the density `falloff(r / radius)`, so it does not depend on how fine the grid is, and the
//! displacement it causes is as smooth as that of a regularised point load (de Goes and James 2017).

use super::key::DEFAULT_RADIUS;
use crate::body::{Body, Discretization, Lattice, LatticeError};
use crate::plan::Edit;
use crate::tool::Tool;
use pliant_solver::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// How the weight of an edit falls from 1 at its centre to 0 at its radius; `r` is the distance over the radius.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Falloff {
    /// `(1 - r)^2 (1 + 2 r)`: level at the centre and at the radius.
    #[default]
    Smooth,
    /// `sqrt(1 - r^2)`: the pressure of a ball (Hertz 1881).
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
    /// The weight at a distance of `r` radii; 0 from 1 on.
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
    /// m
    pub radius: f64,
    /// Weight by distance.
    pub falloff: Falloff,
}

/// Edges of a cell in the least radius of a region: below it, the weight of a node says more about the grid than about the edit.
pub(crate) const LEAST_EDGES: f64 = 1.5;

impl BrushShape {
    /// As an edit with a tool asks for it.
    pub fn of(edit: &Edit, tool: &Tool) -> Self {
        let radius = edit.radius.unwrap_or(DEFAULT_RADIUS * tool.proxy.radius());
        Self { radius, falloff: edit.falloff }
    }

    /// m, the radius on a body whose cells have this edge (m): 1.5 edges at least.
    pub fn radius_at(&self, edge: f64) -> f64 {
        self.radius.max(LEAST_EDGES * edge)
    }
}

/// Nodes of a body and their weights.
#[derive(Debug, Default)]
pub struct Brush {
    /// Numbers, rising (k)
    pub nodes: Vec<u32>,
    /// Falloff at each, 0 to 1 (k)
    pub weight: Vec<f64>,
    /// Share of the load at each: falloff times mass, sum 1 (k)
    pub share: Vec<f64>,
    near: Vec<(u32, f64)>,
}

impl Brush {
    /// Covers the free nodes of `body` around the rest place `centre`, where the grid has it.
    ///
    /// # Errors
    /// What the grid says.
    pub fn cover(&mut self, body: &Body, centre: Vec3, shape: BrushShape) -> Result<(), LatticeError> {
        let radius = shape.radius_at(body.discretization.edge());
        body.nodes_within(centre, radius, &mut self.near)?;
        self.nodes.clear();
        self.weight.clear();
        self.share.clear();
        let nodes = &body.system.nodes;
        for &(node, distance) in &self.near {
            let weight = shape.falloff.weight(distance / radius);
            if weight > 0.0 && nodes.constraint[node as usize].is_free() {
                self.nodes.push(node);
                self.weight.push(weight);
                self.share.push(weight * nodes.mass[node as usize]);
            }
        }
        let total: f64 = self.share.iter().sum();
        self.share.iter_mut().for_each(|share| *share /= total);
        Ok(())
    }

    /// Active cells with a node of the region.
    pub fn cells(&self, lattice: &Lattice) -> Vec<u32> {
        let covered = |corners: &[u32; 8]| corners.iter().any(|n| self.nodes.binary_search(n).is_ok());
        let cells = lattice.region().cell_corners.iter().enumerate();
        cells.filter(|(_, corners)| covered(corners)).map(|(cell, _)| cell as u32).collect()
    }

    /// Vertices of the surface that the region carries, within `radius` (m) of a place of the shape at rest, rising, and their
    /// falloff.
    ///
    /// # Errors
    /// What the grid says.
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

    /// Whether it covers no free node.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Forgets its nodes.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.weight.clear();
        self.share.clear();
    }

    /// The mean of a field over the load, such as m of positions (n x 3).
    pub fn mean(&self, field: &[Vec3]) -> Vec3 {
        self.nodes.iter().zip(&self.share).map(|(&n, share)| *share * field[n as usize]).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Falloff; 6] =
        [Falloff::Smooth, Falloff::Sphere, Falloff::Root, Falloff::Sharp, Falloff::Linear, Falloff::Constant];

    #[test]
    fn every_falloff_is_one_at_the_centre_zero_from_the_radius_on_and_never_rises() {
        for falloff in ALL {
            assert_eq!(falloff.weight(0.0), 1.0, "{falloff:?}");
            assert_eq!((falloff.weight(1.0), falloff.weight(7.0)), (0.0, 0.0), "{falloff:?}");
            let weights: Vec<f64> = (0..=100).map(|i| falloff.weight(f64::from(i) / 100.0)).collect();
            assert!(weights.windows(2).all(|w| w[0] >= w[1]), "{falloff:?}");
        }
    }

    #[test]
    fn the_smooth_falloff_is_level_at_both_ends() {
        let slope = |r: f64| (Falloff::Smooth.weight(r + 1e-6) - Falloff::Smooth.weight(r - 1e-6)) / 2e-6;
        assert!(slope(1e-6).abs() < 1e-4 && slope(1.0 - 1e-6).abs() < 1e-4);
    }
}
