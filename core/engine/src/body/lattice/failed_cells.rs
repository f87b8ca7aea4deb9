//! Tetrahedra of a lattice that have failed (`pliant.failure/1`): which triangles of the surface they carried, and which faces of others come to light.
//!
//! A cube of a grid falls into five tetrahedra, of which some may have failed. What lies in such a cube follows the tetrahedron around it and not
//! all eight corners, some of which may hang on nothing any more.

use super::{Lattice, LatticeError};
use crate::body::disjoint_sets::DisjointSets;
use crate::body::model::Model;
use crate::contact::inward;
use crate::obstacle::MeshSurface;
use pliant_cut::carve::{Carving, Corner, Crossing, Left, jitter};
use pliant_mesh::Surface;
use pliant_mesh::tetrahedra::{FACES, NO_NEIGHBOUR, neighbours};
use pliant_plugin_api::abi;
use pliant_solver::Vec3;
use std::collections::BTreeMap;

/// Halvings of an edge of a tetrahedron that goes out of the body, for the place where it does: to the last bit of its length.
const HALVINGS: usize = 50;
/// Distance from the surface, in edges of a cell, up to which a node counts as inside of the body.
const ON_SURFACE: f64 = 1e-6;
/// Depth under the surface at which it is carved, in edges of a cell.
const CARVED_DEPTH: f64 = 1e-5;
/// Spacing of the points of a triangle at which the tetrahedra it passes through are looked up, in edges of a cell.
const SPACING: f64 = 0.5;

/// What follows from the tetrahedra and the surface, whichever of them have failed; made when the active cells are, for it takes many steps' time.
struct FaceTable {
    /// Nodes of the tetrahedra it was made for (m x 4).
    nodes: Vec<[u32; 4]>,
    /// The tetrahedron on the other side of each face (m x 4).
    neighbours: Vec<[u32; 4]>,
    /// Number of triangles it was made for.
    triangles: usize,
    /// Tetrahedra that triangle t of the surface passes through: `passes[starts[t]..starts[t + 1]]`.
    passes: Vec<u32>,
    starts: Vec<u32>,
    /// Whether each node is inside of the body; empty where all are, as in the tetrahedra of a file.
    is_inside: Vec<bool>,
    /// The surface of the file, for cubes that reach out of it.
    surface: Option<MeshSurface>,
    /// Vertices of the surface, moved inwards by a little, and positions of the nodes in general position, m; empty where the surface is not carved.
    carved: [Vec<Vec3>; 2],
    /// Where edges that have been asked for go through it, as a share of the way from the lower node.
    leaves: BTreeMap<[u32; 2], f64>,
}

/// The tetrahedra that have failed.
#[derive(Default)]
pub(super) struct FailedCells {
    /// Whether each tetrahedron has failed; empty if none has (m).
    has_failed: Vec<bool>,
    /// Vertices of the surface whose triangles are all gone, ascending.
    loose: Vec<u32>,
    /// Active cells in which faces have come to light, with the state that each had before.
    exposed: Vec<(u32, u8)>,
    table: Option<Box<FaceTable>>,
}

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
    /// Number of tetrahedra of each cell.
    pub(super) fn tetrahedra_per_cell(&self) -> usize {
        if self.source.tetrahedra().is_some() { 1 } else { 5 }
    }

    /// Nodes of the tetrahedra of an active cell, in the order of its elements.
    fn tetrahedra_in(&self, cell: u32) -> impl Iterator<Item = [u32; 4]> + '_ {
        let corners = &self.region.cell_corners[cell as usize];
        let all = self.source.tetrahedra_of(&self.region, &self.facts, cell);
        all.iter().map(|tetrahedron| tetrahedron.map(|corner| corners[corner as usize]))
    }

    /// Barycentric coordinates of a rest position (m) in a tetrahedron of these nodes.
    fn barycentric(&self, nodes: [u32; 4], place: Vec3) -> [f64; 4] {
        let [a, b, c, d] = nodes.map(|node| self.grid_rest(node));
        let (u, v, w, p) = (b - a, c - a, d - a, place - a);
        let volume = u.dot(&v.cross(&w));
        let [x, y, z] = [p.dot(&v.cross(&w)), p.dot(&w.cross(&u)), p.dot(&u.cross(&v))].map(|part| part / volume);
        [1.0 - x - y - z, x, y, z]
    }

    /// The tetrahedron of an active cell, counted in it, that contains a rest position (m), or of those for which `is_wanted` holds the nearest one.
    fn tetrahedron_in(&self, cell: u32, place: Vec3, is_wanted: impl Fn(usize) -> bool) -> Option<(usize, [f64; 4])> {
        let all = self.tetrahedra_in(cell).enumerate().filter(|(index, _)| is_wanted(*index));
        let with_least = all.map(|(index, nodes)| {
            let weights = self.barycentric(nodes, place);
            (weights.into_iter().fold(f64::INFINITY, f64::min), index, weights)
        });
        let best = with_least.reduce(|best, other| if other.0 > best.0 { other } else { best });
        best.map(|(_, index, weights)| (index, weights))
    }

    /// Replaces the trilinear weights of a rest position (m) in an active cell of which tetrahedra have failed by those of the one around it.
    pub(super) fn limit_weights(&self, cell: u32, place: Vec3, weights: &mut [f64; 8]) {
        let count = self.tetrahedra_per_cell();
        let first = count * cell as usize;
        let Some(failed) = self.failed.has_failed.get(first..first + count).filter(|_| count > 1) else { return };
        if !failed.contains(&true) {
            return;
        }
        let Some((index, barycentric)) = self.tetrahedron_in(cell, place, |index| !failed[index]) else { return };
        *weights = [0.0; 8];
        let corners = self.source.tetrahedra_of(&self.region, &self.facts, cell)[index];
        corners.iter().zip(barycentric).for_each(|(corner, weight)| weights[*corner as usize] = weight);
    }

    /// Whether the triangles of a vertex of the surface are all gone: nothing meets it.
    pub(super) fn is_loose(&self, vertex: u32) -> bool {
        self.failed.loose.binary_search(&vertex).is_ok()
    }

    /// Forgets which tetrahedra have failed, whose numbers are those of the active cells, before these change.
    pub(super) fn forget_failed_cells(&mut self) {
        self.withdraw_surface_cells();
        self.failed.has_failed.clear();
        self.failed.table = None;
    }

    /// Gives cells in which faces had come to light the state that they had before.
    pub(in crate::body) fn withdraw_surface_cells(&mut self) {
        for (cell, state) in std::mem::take(&mut self.failed.exposed) {
            self.region.cell_state[cell as usize] = state;
        }
    }

    /// Lists the vertices whose triangles are all gone.
    pub(in crate::body) fn set_loose(&mut self, vertices: Vec<u32>) {
        self.failed.loose = vertices;
    }

    /// The vertex of the surface at each active node (n); empty for a grid, whose nodes are not vertices.
    fn vertices_of_nodes(&self) -> Vec<Option<u32>> {
        let Some(cells) = self.source.tetrahedra() else { return Vec::new() };
        let vertices = cells.mesh().vertices();
        let vertex_of = |node: &u64| vertices.binary_search(&(*node as u32)).ok().map(|vertex| vertex as u32);
        self.region.node_id.iter().map(vertex_of).collect()
    }

    /// The connected part of the tetrahedra left that each active node belongs to (n), and for each triangle of the surface a node of a tetrahedron it passes through, if
    /// that is left (t); `None` where none has failed.
    pub(in crate::body) fn parts_left(&self) -> Option<(Vec<u32>, Vec<Option<u32>>)> {
        let table = self.failed.table.as_ref().filter(|_| self.has_failed_cells())?;
        let has_failed = |tetrahedron: u32| self.failed.has_failed.get(tetrahedron as usize).copied().unwrap_or(true);
        let mut sets = DisjointSets::new(self.region.node_id.len());
        for (nodes, tetrahedron) in table.nodes.iter().zip(0..) {
            if !has_failed(tetrahedron) {
                nodes[1..].iter().for_each(|node| sets.unite(nodes[0], *node));
            }
        }
        let part_of = (0..self.region.node_id.len() as u32).map(|node| sets.find(node)).collect();
        let passed = |t: usize| &table.passes[table.starts[t] as usize..table.starts[t + 1] as usize];
        let node_of = |t: usize| passed(t).first().filter(|e| !has_failed(**e)).map(|e| table.nodes[*e as usize][0]);
        Some((part_of, (0..table.triangles).map(node_of).collect()))
    }

    /// Whether tetrahedra have failed.
    pub fn has_failed_cells(&self) -> bool {
        !self.failed.has_failed.is_empty()
    }

    /// Whether tetrahedra of the material are those of cells, so that the surface can follow their failure: `nodes` are those of its elements.
    pub(in crate::body) fn lists_all_tetrahedra(&self, nodes: &[u32]) -> bool {
        nodes.len() == 4 * self.tetrahedra_per_cell() * self.region.cell_corners.len()
    }

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
        let passed = |t: usize| &table.passes[table.starts[t] as usize..table.starts[t + 1] as usize];
        let is_gone = |t: usize| passed(t).iter().any(|tetrahedron| has_failed[*tetrahedron as usize]);
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
        let passed = |t: u32| &table.passes[table.starts[t as usize] as usize..table.starts[t as usize + 1] as usize];
        let triangles = &model.surface.triangles;
        let [points, nodes] = &table.carved;
        let carved = Carving { points, triangles, nodes, faces, spacing: self.edge() }
            .carve(|node| table.is_inside[node as usize], |t| passed(t).iter().any(has_failed));
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

    /// Makes the table that failures need, if the one there is was made for other tetrahedra than those of these `nodes` (4 m) or for another surface.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn prepare_failure(&mut self, nodes: &[u32], model: &Model) -> Result<(), LatticeError> {
        let (nodes, _) = nodes.as_chunks::<4>();
        let is_current = |table: &FaceTable| table.nodes == nodes && table.triangles == model.surface.triangles.len();
        if !self.failed.table.as_deref().is_some_and(is_current) {
            self.failed.table = Some(Box::new(self.face_table(nodes, model)?));
        }
        Ok(())
    }

    /// Makes the table for these tetrahedra and the surface of a model.
    fn face_table(&self, nodes: &[[u32; 4]], model: &Model) -> Result<FaceTable, LatticeError> {
        let triangles = model.surface.triangles.len();
        let (mut passes, mut starts) = (Vec::new(), vec![0]);
        for corners in &model.surface.triangles {
            let first = passes.len();
            self.passes_through(corners.map(|v| model.surface.points[v as usize]), &mut passes)?;
            passes[first..].sort_unstable();
            let mut last = None;
            let mut kept = first;
            for i in first..passes.len() {
                if last.replace(passes[i]) != Some(passes[i]) {
                    passes[kept] = passes[i];
                    kept += 1;
                }
            }
            passes.truncate(kept);
            starts.push(passes.len() as u32);
        }
        // The tetrahedra of a file end at its surface; one that is open has no inside.
        let is_of_file = self.source.tetrahedra().is_some();
        let carved = if is_of_file || self.has_cuts() { Default::default() } else { self.carved_points(model) };
        let moved = Surface { points: carved[0].clone(), ..model.surface.clone() };
        let judged = if carved[0].is_empty() { &model.surface } else { &moved };
        let surface = if is_of_file { None } else { MeshSurface::new(judged, 0.0).ok() };
        // An open surface has no inside to be carved.
        let carved = if surface.is_some() { carved } else { Default::default() };
        let is_inside = surface.as_ref().map_or_else(Vec::new, |surface| {
            let nodes = 0..self.region.node_id.len() as u32;
            let place = |n: u32| carved[1].get(n as usize).copied().unwrap_or_else(|| self.grid_rest(n));
            let margin = if carved[1].is_empty() { ON_SURFACE * self.edge() } else { 0.0 };
            nodes.map(|n| surface.nearest(place(n)).distance <= margin).collect()
        });
        Ok(FaceTable {
            nodes: nodes.to_vec(),
            neighbours: neighbours(nodes),
            triangles,
            passes,
            starts,
            is_inside,
            surface,
            carved,
            leaves: BTreeMap::new(),
        })
    }

    /// Vertices of the surface and positions of the nodes by which it is carved, m. Vertices are a little inside of the surface: where it lies in a plane of nodes, the
    /// cells inside of it carry it.
    fn carved_points(&self, model: &Model) -> [Vec<Vec3>; 2] {
        let surface = &model.surface;
        let mut normals = vec![Vec3::zeros(); surface.points.len()];
        for corners in &surface.triangles {
            let [a, b, c] = corners.map(|v| surface.points[v as usize]);
            corners.iter().for_each(|v| normals[*v as usize] += (b - a).cross(&(c - a)));
        }
        let inside = |(point, normal): (&Vec3, &Vec3)| {
            point - CARVED_DEPTH * self.edge() * normal.try_normalize(0.0).unwrap_or_default()
        };
        let ids = self.region.node_id.iter().zip(0..);
        let nodes = ids.map(|(id, node)| jitter(self.grid_rest(node), *id, self.edge())).collect();
        [surface.points.iter().zip(&normals).map(inside).collect(), nodes]
    }

    /// Lists the tetrahedra that a triangle (m) passes through: those under its centroid, and of cubes those at points all over it.
    fn passes_through(&self, corners: [Vec3; 3], out: &mut Vec<u32>) -> Result<(), LatticeError> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a));
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let is_of_file = self.source.tetrahedra().is_some();
        let parts = if is_of_file { 0 } else { ((longest / (SPACING * self.edge())).ceil() as usize).clamp(1, 64) };
        let per_cell = self.tetrahedra_per_cell() as u32;
        let mut look = |weights: [f64; 3]| -> Result<(), LatticeError> {
            let point = inward(weights[0] * a + weights[1] * b + weights[2] * c, normal, self.edge());
            if let Some(cell) = self.cell_of(point)? {
                let found = self.tetrahedron_in(cell as u32, point, |_| true);
                out.extend(found.map(|(index, _)| per_cell * cell as u32 + index as u32));
            }
            Ok(())
        };
        look([1.0 / 3.0; 3])?;
        for i in 0..=parts {
            for j in 0..=parts - i {
                if parts > 0 {
                    let [u, v] = [i, j].map(|at| at as f64 / parts as f64);
                    look([1.0 - u - v, u, v])?;
                }
            }
        }
        Ok(())
    }
}
