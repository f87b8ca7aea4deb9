//! The surface that failed tetrahedra leave: triangles that are gone, pieces of others, and faces that have come to light.

use super::face_table::{FaceTable, ON_SURFACE};
use super::{Lattice, LatticeError};
use crate::body::model::Model;
use crate::obstacle::MeshSurface;
use pliant_cut::carve::{Carving, Corner, Crossing, Left};
use pliant_mesh::tetrahedra::{FACES, NO_NEIGHBOUR};
use pliant_plugin_api::abi;
use pliant_solver::Vec3;
use std::collections::BTreeMap;

/// Halvings of an edge of a tetrahedron that goes out of the body, for the place where it does: to the last bit of its length.
const HALVINGS: usize = 50;

/// A place on an edge between two nodes, or at one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct EdgePlace {
    /// The two nodes, the lower number first; at a node twice the same.
    nodes: [u32; 2],
    /// Share of the second node, 0 to 1.
    share: f64,
}

/// A place among nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::body) struct NodePlace {
    /// In the rest shape of the file, m.
    pub rest: Vec3,
    /// Up to three nodes.
    pub nodes: [u32; 3],
    /// Shares of the nodes; they add up to 1.
    pub weights: [f64; 3],
}

impl NodePlace {
    /// The place, whose position in another field is `of_rest` (m), moved by displacements of its nodes, or at its node.
    pub fn moved(&self, of_rest: Vec3, at: impl Fn(u32) -> Vec3, displacement: impl Fn(u32) -> Vec3) -> Vec3 {
        if self.weights[0] == 1.0 {
            return at(self.nodes[0]);
        }
        self.nodes.iter().zip(self.weights).fold(of_rest, |sum, (node, weight)| sum + weight * displacement(*node))
    }
}

/// A corner of a triangle that failure has made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::body) enum ExposedCorner {
    /// A vertex of the surface.
    Vertex(u32),
    /// An index of [`BrokenSurface::places`].
    Place(u32),
}

/// A triangle that failure has made, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::body) struct ExposedTriangle {
    pub corners: [ExposedCorner; 3],
    /// The triangle of the surface of which it is a piece; `None` for a part of a face that has come to light.
    pub of: Option<u32>,
}

/// What tetrahedra that have failed make of the surface.
#[derive(Default)]
pub(in crate::body) struct BrokenSurface {
    /// Whether each triangle of the surface is gone, or has come to pieces (t).
    pub is_gone: Vec<bool>,
    /// Vertices of the triangles that failure has made.
    pub places: Vec<NodePlace>,
    /// Triangles that failure has made, first pieces of triangles of the surface, then faces that have come to light.
    pub exposed: Vec<ExposedTriangle>,
}

impl Lattice {
    /// Takes over which tetrahedra have failed (1, else 0), and finds what that makes of the surface of `model` without faces that have come to light. `nodes` are those
    /// of the tetrahedra (4 m).
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn break_surface(
        &mut self,
        nodes: &[u32],
        failed: &[u8],
        model: &Model,
    ) -> Result<BrokenSurface, LatticeError> {
        self.weights.clear();
        self.weights_of.fill(super::NO_WEIGHTS);
        self.failed.has_failed.clear();
        if !failed.contains(&1) {
            return Ok(BrokenSurface::default());
        }
        self.failed.has_failed.extend(failed.iter().map(|failed| *failed != 0));
        self.prepare_failure(nodes, model)?;
        let Some(mut table) = self.failed.table.take() else { return Ok(BrokenSurface::default()) };
        let (nodes, _) = nodes.as_chunks::<4>();
        let has_failed = &self.failed.has_failed;
        let is_gone = |t: usize| table.passed(t).iter().any(|tetrahedron| has_failed[*tetrahedron as usize]);
        let is_gone = (0..table.triangles).map(is_gone).collect();
        let per_cell = self.tetrahedra_per_cell() as u32;
        // Faces between one that is left and one that is not, and the cell of the first.
        let (mut faces, mut cells) = (Vec::new(), Vec::new());
        for (tetrahedron, others) in table.neighbours.iter().enumerate().filter(|(e, _)| !has_failed[*e]) {
            for (face, other) in FACES.iter().zip(others) {
                if *other != NO_NEIGHBOUR && has_failed[*other as usize] {
                    faces.push(face.map(|corner| nodes[tetrahedron][corner]));
                    cells.push(tetrahedron as u32 / per_cell);
                }
            }
        }
        for cell in cells {
            // Contact looks for the surface in cells of this state alone.
            let state = &mut self.region.cell_state[cell as usize];
            if u32::from(*state) != abi::CELL_SURFACE {
                self.failed.exposed.push((cell, std::mem::replace(state, abi::CELL_SURFACE as u8)));
            }
        }
        let broken = match table.carved[0].is_empty() {
            true => self.clip_faces(&mut table, &faces, is_gone),
            false => self.carve(&table, &faces, model),
        };
        self.failed.table = Some(table);
        Ok(broken)
    }

    /// The surface carved by faces: closed, as it was.
    fn carve(&self, table: &FaceTable, faces: &[[u32; 3]], model: &Model) -> BrokenSurface {
        let has_failed = |e: &u32| self.failed.has_failed[*e as usize];
        let triangles = &model.surface.triangles;
        let [points, nodes] = &table.carved;
        let carved = Carving { points, triangles, nodes, faces, spacing: self.edge() }
            .carve(|node| table.is_inside[node as usize], |t| table.passed(t as usize).iter().any(has_failed));
        let mut places: Vec<NodePlace> = Vec::with_capacity(carved.crossings.len());
        for Crossing { vertices, vertex_weights, nodes, node_weights } in &carved.crossings {
            let shares = vertices.iter().zip(vertex_weights);
            let rest = shares.map(|(v, w)| *w * model.surface.points[*v as usize]).sum();
            places.push(NodePlace { rest, nodes: *nodes, weights: *node_weights });
        }
        let mut at_node: BTreeMap<u32, u32> = BTreeMap::new();
        let mut corner = |corner: Corner| match corner {
            Corner::Vertex(vertex) => ExposedCorner::Vertex(vertex),
            Corner::Crossing(crossing) => ExposedCorner::Place(crossing),
            Corner::Node(node) => ExposedCorner::Place(*at_node.entry(node).or_insert_with(|| {
                places.push(NodePlace { rest: self.grid_rest(node), nodes: [node; 3], weights: [1.0, 0.0, 0.0] });
                places.len() as u32 - 1
            })),
        };
        let of_surface = carved.pieces.iter().map(|(t, corners)| (Some(*t), corners));
        let all = of_surface.chain(carved.faces.iter().map(|(_, corners)| (None, corners)));
        let exposed = all.map(|(of, corners)| ExposedTriangle { corners: corners.map(&mut corner), of }).collect();
        BrokenSurface { is_gone: carved.left.iter().map(|left| *left != Left::Whole).collect(), places, exposed }
    }

    /// Faces clipped at the surface of the file, where there is one, beside the triangles that are left.
    fn clip_faces(&self, table: &mut FaceTable, faces: &[[u32; 3]], is_gone: Vec<bool>) -> BrokenSurface {
        let mut leaves = std::mem::take(&mut table.leaves);
        let vertex_of_node = self.vertices_of_nodes();
        // By their bits, so that faces with a common edge have common vertices.
        let mut known: BTreeMap<([u32; 2], u64), u32> = BTreeMap::new();
        let (mut places, mut exposed) = (Vec::new(), Vec::new());
        let mut corner = |EdgePlace { nodes, share }: EdgePlace| {
            let of_node = vertex_of_node.get(nodes[0] as usize).copied().flatten();
            if let Some(vertex) = of_node.filter(|_| nodes[0] == nodes[1]) {
                return ExposedCorner::Vertex(vertex);
            }
            ExposedCorner::Place(*known.entry((nodes, share.to_bits())).or_insert_with(|| {
                let [a, b] = nodes.map(|node| self.grid_rest(node));
                let weights = [1.0 - share, share, 0.0];
                places.push(NodePlace { rest: a.lerp(&b, share), nodes: [nodes[0], nodes[1], nodes[1]], weights });
                places.len() as u32 - 1
            }))
        };
        for face in faces {
            let polygon = self.clip(table, *face, &mut leaves);
            for i in 2..polygon.len() {
                let corners = [polygon[0], polygon[i - 1], polygon[i]].map(&mut corner);
                exposed.push(ExposedTriangle { corners, of: None });
            }
        }
        table.leaves = leaves;
        BrokenSurface { is_gone, places, exposed }
    }

    /// The part of a face that is inside of the body, as a polygon.
    fn clip(&self, table: &FaceTable, corners: [u32; 3], leaves: &mut BTreeMap<[u32; 2], f64>) -> Vec<EdgePlace> {
        let is_inside = |node: u32| table.is_inside.get(node as usize).copied().unwrap_or(true);
        let mut polygon: Vec<EdgePlace> = Vec::with_capacity(4);
        for i in 0..3 {
            let (from, to) = (corners[i], corners[(i + 1) % 3]);
            if is_inside(from) {
                polygon.push(EdgePlace { nodes: [from; 2], share: 0.0 });
            }
            if is_inside(from) != is_inside(to) {
                let nodes = [from.min(to), from.max(to)];
                let place = |surface| *leaves.entry(nodes).or_insert_with(|| self.leaves_body(surface, nodes));
                polygon.extend(table.surface.as_ref().map(place).map(|share| EdgePlace { nodes, share }));
            }
        }
        polygon
    }

    /// Where the edge between two nodes, one inside of the body and one outside, goes through its surface, as a share of the way from the first.
    fn leaves_body(&self, surface: &MeshSurface, nodes: [u32; 2]) -> f64 {
        let [from, to] = nodes.map(|node| self.grid_rest(node));
        let distance = |share: f64| surface.nearest(from.lerp(&to, share)).distance;
        let is_first_inside = distance(0.0) <= ON_SURFACE * self.edge();
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match (distance(middle) <= ON_SURFACE * self.edge()) == is_first_inside {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }
}
