//! The points of a body that may reach an obstacle in a step.
//!
//! A vertex of a sheet, or a cell of a solid, is asked for its distance only when it may have come near: what was left at its last question, less
//! what body and obstacle have moved since.

use super::placed::PlacedObstacle;
use crate::body::{Body, ContactBuffers, ContactSurface, Discretization, LatticeError};
use pliant_solver::{Nodes, Vec3};

/// A point of the surface of a body, carried by nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// Nodes that carry it; those of weight 0 repeat others.
    pub nodes: [u32; 8],
    /// Weights of the nodes; they add up to 1.
    pub weights: [f64; 8],
    /// Number of nodes: 1 on a sheet, 8 in a cell.
    pub count: u8,
    /// Position less the weighted sum of its nodes' positions, m.
    pub offset: Vec3,
    /// Index of the obstacle.
    pub obstacle: u32,
}

/// Smallest weight of a node that contact at a point constrains, relative to the largest of its weights.
const CARRIES: f64 = 0.3;

impl Point {
    /// Weighted sum of a nodal field.
    pub fn mean(&self, field: impl Fn(usize) -> Vec3) -> Vec3 {
        self.carriers().fold(Vec3::zeros(), |sum, (node, weight)| sum + weight * field(node as usize))
    }

    /// Position of the point, from the nodes that carry it, m.
    pub fn position(&self, nodes: &Nodes) -> Vec3 {
        self.offset + self.mean(|i| nodes.x[i])
    }

    /// Nodes and weights.
    pub fn carriers(&self) -> impl Iterator<Item = (u32, f64)> + Clone + '_ {
        let count = usize::from(self.count);
        self.nodes[..count].iter().copied().zip(self.weights[..count].iter().copied())
    }

    /// The nodes that contact at the point constrains.
    pub fn constrained(&self) -> impl Iterator<Item = u32> + '_ {
        let least = CARRIES * self.carriers().fold(0.0, |most: f64, (_, weight)| most.max(weight));
        self.carriers().filter(move |(_, weight)| *weight >= least).map(|(node, _)| node)
    }
}

/// Candidates of a body for contact with obstacles, and until when the others need no look.
#[derive(Default)]
pub(super) struct Candidates {
    /// Nodes of a sheet, or surface cells of a solid, in which points are.
    carriers: Vec<u32>,
    /// Nodes of a sheet that meet nothing, ascending: those whose triangles have failed.
    loose_nodes: Vec<u32>,
    /// For each obstacle and carrier: travel at which they could touch, m.
    due: Vec<f64>,
    /// Obstacles and carriers that are near each other in this step.
    near: Vec<(u32, u32)>,
    /// What body and obstacles have moved since the list was made, m.
    travel: f64,
    buffers: ContactBuffers,
    /// Whether the list of carriers must be made again.
    is_outdated: bool,
}

/// Slack of a candidate, in edges of the body: a step may accelerate.
const SLACK: f64 = 0.1;

impl Candidates {
    /// Marks the list of carriers as outdated, after nodes or cells have changed.
    pub fn invalidate(&mut self) {
        self.is_outdated = true;
    }

    /// Replaces `points` by those that may reach an obstacle while body and obstacles move by up to `reach` (m). `moved` is what they have moved since the last
    /// call, m.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn find(
        &mut self,
        body: &mut Body,
        obstacles: &[PlacedObstacle],
        moved: f64,
        reach: f64,
        points: &mut Vec<Point>,
    ) -> Result<(), LatticeError> {
        let Body { discretization, system, samples, failed_triangles, .. } = &mut *body;
        let nodes = &system.nodes;
        if self.loose_nodes != failed_triangles.loose_nodes() {
            self.loose_nodes = failed_triangles.loose_nodes().to_vec();
            self.is_outdated = true;
        }
        if self.is_outdated || self.due.is_empty() {
            self.carriers.clear();
            match discretization {
                Discretization::Sheet(sheet) => {
                    let is_met = |n: &u32| sheet.vertex_of(*n).is_some() && self.loose_nodes.binary_search(n).is_err();
                    self.carriers.extend((0..nodes.len() as u32).filter(is_met));
                }
                Discretization::Lattice(lattice) => self.carriers = lattice.surface_cells(samples)?,
            }
            self.due.clear();
            self.due.resize(obstacles.len() * self.carriers.len(), f64::NEG_INFINITY);
            (self.travel, self.is_outdated) = (0.0, false);
        }
        self.travel += moved;
        let reach = reach + SLACK * discretization.edge();
        self.near.clear();
        for (index, (obstacle, due)) in
            obstacles.iter().zip(self.due.chunks_mut(self.carriers.len().max(1))).enumerate()
        {
            for (carrier, due) in self.carriers.iter().zip(due) {
                if self.travel + reach < *due {
                    continue;
                }
                let distance = match discretization {
                    Discretization::Sheet(_) => obstacle.nearest(nodes.x[*carrier as usize]).distance,
                    Discretization::Lattice(lattice) => {
                        let corners = lattice.corners(*carrier, &nodes.x);
                        let centre = corners.iter().sum::<Vec3>() / 8.0;
                        let radius = corners.iter().fold(0.0, |r: f64, x| r.max((x - centre).norm()));
                        obstacle.nearest(centre).distance - radius
                    }
                };
                *due = self.travel + distance;
                if distance <= reach {
                    self.near.push((index as u32, *carrier));
                }
            }
        }
        self.list(body, points)
    }

    /// Obstacles and cells or vertices that were found near each other.
    pub fn near(&self) -> &[(u32, u32)] {
        &self.near
    }

    /// Replaces `points` by those of the carriers that were found near, where they are now.
    fn list(&mut self, body: &mut Body, points: &mut Vec<Point>) -> Result<(), LatticeError> {
        points.clear();
        let Body { discretization, model, skin, system, samples, .. } = body;
        let nodes = &system.nodes;
        for &(obstacle, carrier) in &self.near {
            let Discretization::Lattice(lattice) = discretization else {
                let (weights, offset) = ([1.0; 8], Vec3::zeros());
                points.push(Point { nodes: [carrier; 8], weights, count: 1, offset, obstacle });
                continue;
            };
            let mut surface = ContactSurface { nodes, model, skin, samples, buffers: &mut self.buffers };
            lattice.visit_contact_points(carrier, &mut surface, |at| {
                let mut point =
                    Point { nodes: at.nodes, weights: at.weights, count: 8, offset: Vec3::zeros(), obstacle };
                point.offset = at.position - point.mean(|i| nodes.x[i]);
                points.push(point);
            })?;
        }
        Ok(())
    }
}
