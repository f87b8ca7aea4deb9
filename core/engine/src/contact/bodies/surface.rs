//! The surface of a body for contact with other bodies: vertices that nodes carry, triangles and edges.

use super::tree::{Bounds, BoxTree};
use crate::body::{Body, Discretization, LatticeError};
use pliant_solver::Vec3;
use std::collections::HashMap;

/// A vertex without a node stays where it is.
const NO_VERTEX: u32 = u32::MAX;

/// The surface of a body. It is made again when nodes or triangles have changed.
#[derive(Default)]
pub(super) struct CollisionSurface {
    /// First carrier of each vertex, and the end of the last (v + 1).
    first: Vec<u32>,
    /// Nodes that carry vertices, with their weights, which add up to 1 for each vertex.
    carriers: Vec<(u32, f64)>,
    /// Position of each vertex less the weighted sum of its nodes' positions, m (v x 3).
    offset: Vec<Vec3>,
    /// Vertex of this surface of each vertex of the model, or [`NO_VERTEX`].
    vertex_of: Vec<u32>,
    /// Vertices of each triangle (t x 3).
    pub triangles: Vec<[u32; 3]>,
    /// Vertices of each edge (e x 2).
    pub edges: Vec<[u32; 2]>,
    /// Vertices and edges that each triangle looks after, so that each is tested once (t x 3).
    pub own_vertices: Vec<[bool; 3]>,
    /// Number of each edge of a triangle that looks after it, or [`NO_EDGE`] (t x 3).
    pub own_edges: Vec<[u32; 3]>,
    /// Tree over the triangles.
    pub tree: BoxTree,
    /// Mean length of an edge, m.
    pub edge: f64,
    /// Whether it must be made again.
    pub is_outdated: bool,
}

/// An edge that another triangle looks after.
pub(super) const NO_EDGE: u32 = u32::MAX;

impl CollisionSurface {
    /// A surface that is still to be made.
    pub fn outdated() -> Self {
        Self { is_outdated: true, ..Self::default() }
    }

    /// The surface of a body as it is now.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn new(body: &mut Body) -> Result<Self, LatticeError> {
        let mut surface = Self { first: vec![0], ..Self::default() };
        let model = std::sync::Arc::clone(&body.model);
        let triangles = (0..model.surface.triangles.len() as u32)
            .filter(|t| !model.is_lid(*t) && !body.failed_triangles.contains(*t));
        match &mut body.discretization {
            Discretization::Sheet(sheet) => {
                surface.triangles = triangles.map(|t| sheet.nodes_of(&model, t)).collect();
                for node in 0..sheet.vertex_count() as u32 {
                    surface.add_vertex(std::iter::once((node, 1.0)), Vec3::zeros());
                }
                let is_used = |v: &u32| !model.around(*v).is_empty();
                let vertices = 0..model.surface.points.len() as u32;
                surface.vertex_of = vertices.map(|v| if is_used(&v) { sheet.node_of(v) } else { NO_VERTEX }).collect();
            }
            Discretization::Lattice(lattice) => {
                let mut vertex_of = vec![NO_VERTEX; model.surface.points.len()];
                let nodes = &body.system.nodes;
                let settled = &body.skin.settled;
                lattice.visit_vertices(&model, |vertex, corners, weights| {
                    let carriers = corners.iter().copied().zip(weights.iter().copied()).filter(|(_, w)| *w != 0.0);
                    let mean = carriers.clone().fold(Vec3::zeros(), |sum, (n, w)| sum + w * nodes.rest[n as usize]);
                    vertex_of[vertex as usize] = surface.add_vertex(carriers, settled[vertex as usize] - mean);
                })?;
                // Vertices of faces that have come to light lie on edges and faces between nodes.
                let exposed = body.failed_triangles.exposed();
                for (vertex, carriers) in exposed.vertices().zip(exposed.carriers()) {
                    let mean = carriers.iter().map(|(n, w)| *w * nodes.rest[*n as usize]).sum::<Vec3>();
                    vertex_of[vertex as usize] = surface
                        .add_vertex(carriers.into_iter().filter(|(_, w)| *w != 0.0), settled[vertex as usize] - mean);
                }
                for corners in triangles.map(|t| model.surface.triangles[t as usize]) {
                    for v in corners {
                        if vertex_of[v as usize] == NO_VERTEX {
                            vertex_of[v as usize] = surface.add_vertex(std::iter::empty(), settled[v as usize]);
                        }
                    }
                    surface.triangles.push(corners.map(|v| vertex_of[v as usize]));
                }
                surface.vertex_of = vertex_of;
            }
        }
        surface.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        surface.find_edges();
        let mut at = Vec::new();
        surface.positions(&body.system.nodes.x, &mut at);
        let length = |[a, b]: &[u32; 2]| (at[*a as usize] - at[*b as usize]).norm();
        surface.edge = surface.edges.iter().map(length).sum::<f64>() / surface.edges.len().max(1) as f64;
        let centre = |t: &[u32; 3]| t.iter().map(|v| at[*v as usize]).sum::<Vec3>() / 3.0;
        surface.tree = BoxTree::new(&surface.triangles.iter().map(centre).collect::<Vec<_>>());
        Ok(surface)
    }

    fn add_vertex(&mut self, carriers: impl Iterator<Item = (u32, f64)>, offset: Vec3) -> u32 {
        self.carriers.extend(carriers);
        self.first.push(self.carriers.len() as u32);
        self.offset.push(offset);
        self.offset.len() as u32 - 1
    }

    /// Lists the edges, and gives each vertex and edge to the first triangle that has it.
    fn find_edges(&mut self) {
        let mut is_owned = vec![false; self.vertices()];
        let mut numbers = HashMap::new();
        for corners in &self.triangles {
            self.own_vertices.push(corners.map(|v| !std::mem::replace(&mut is_owned[v as usize], true)));
            let sides = [[0, 1], [1, 2], [2, 0]].map(|[i, j]: [usize; 2]| [corners[i], corners[j]]);
            self.own_edges.push(sides.map(|[a, b]| {
                let ends = [a.min(b), a.max(b)];
                if numbers.insert(ends, ()).is_some() {
                    return NO_EDGE;
                }
                self.edges.push(ends);
                self.edges.len() as u32 - 1
            }));
        }
    }

    /// Number of vertices.
    pub fn vertices(&self) -> usize {
        self.offset.len()
    }

    /// Nodes that carry a vertex, with their weights.
    pub fn carriers(&self, vertex: u32) -> &[(u32, f64)] {
        &self.carriers[self.first[vertex as usize] as usize..self.first[vertex as usize + 1] as usize]
    }

    /// The vertex of this surface at a vertex of the model; `None` where the model has none there.
    pub fn vertex_of(&self, vertex: u32) -> Option<u32> {
        self.vertex_of.get(vertex as usize).copied().filter(|v| *v != NO_VERTEX)
    }

    /// Weighted sums of a nodal field (n x 3) at the vertices, appended to `out` (v x 3).
    pub fn interpolate(&self, field: &[Vec3], out: &mut Vec<Vec3>) {
        out.extend((0..self.vertices() as u32).map(|vertex| {
            self.carriers(vertex).iter().fold(Vec3::zeros(), |sum, (n, w)| sum + *w * field[*n as usize])
        }));
    }

    /// Position of a vertex for nodes at `x` (m, n x 3).
    pub fn position(&self, vertex: u32, x: &[Vec3]) -> Vec3 {
        let sum = |sum: Vec3, (n, w): &(u32, f64)| sum + *w * x[*n as usize];
        self.carriers(vertex).iter().fold(self.offset[vertex as usize], sum)
    }

    /// Positions of the vertices for nodes at `x` (m, n x 3), appended to `out` (m, v x 3).
    pub fn positions(&self, x: &[Vec3], out: &mut Vec<Vec3>) {
        let first = out.len();
        self.interpolate(x, out);
        out[first..].iter_mut().zip(&self.offset).for_each(|(at, offset)| *at += offset);
    }

    /// Brings the tree up to date with vertices that move from `from` to `to` (m, v x 3).
    pub fn refit(&mut self, from: &[Vec3], to: &[Vec3]) {
        let Self { tree, triangles, .. } = self;
        tree.refit(|t| {
            let corners = triangles[t as usize].map(|v| v as usize);
            corners.iter().fold(super::tree::EMPTY, |[low, high]: Bounds, &v| {
                [low.inf(&from[v]).inf(&to[v]), high.sup(&from[v]).sup(&to[v])]
            })
        });
    }

    /// Memory of the surface, bytes.
    pub fn bytes(&self) -> usize {
        self.carriers.len() * 16
            + self.vertices() * 28
            + self.vertex_of.len() * 4
            + self.triangles.len() * (12 + 3 + 12 + 120)
            + self.edges.len() * 8
    }
}
