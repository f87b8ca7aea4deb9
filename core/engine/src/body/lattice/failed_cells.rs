//! Tetrahedra of a lattice that have failed (`pliant.failure/1`): which triangles of the surface they carried, and which faces of others come to light.
//!
//! A cube of a grid falls into five tetrahedra, of which some may have failed. What lies in such a cube follows the tetrahedron around it and not
//! all eight corners, some of which may hang on nothing any more.

use super::{Lattice, LatticeError};
use crate::body::disjoint_sets::DisjointSets;
use crate::body::model::Model;
use crate::contact::inward;
use crate::obstacle::MeshSurface;
use pliant_mesh::tetrahedra::{FACES, NO_NEIGHBOUR, neighbours};
use pliant_plugin_api::abi;
use pliant_solver::Vec3;
use std::collections::BTreeMap;

/// Halvings of an edge of a tetrahedron that goes out of the body, for the place where it does: to the last bit of its length.
const HALVINGS: usize = 50;
/// Distance from the surface, in edges of a cell, up to which a node counts as inside of the body.
const ON_SURFACE: f64 = 1e-6;
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
pub(in crate::body) struct EdgePlace {
    /// The two nodes, the lower number first; at a node twice the same.
    pub nodes: [u32; 2],
    /// Share of the second node, 0 to 1.
    pub share: f64,
}

/// What tetrahedra that have failed make of the surface.
#[derive(Default)]
pub(in crate::body) struct BrokenSurface {
    /// Whether each triangle of the surface is gone (t).
    pub is_gone: Vec<bool>,
    /// Corners of triangles of faces that have come to light, counter-clockwise seen from outside, and the cell each bounds (f).
    pub exposed: Vec<([EdgePlace; 3], u32)>,
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
    pub(in crate::body) fn vertices_of_nodes(&self) -> Vec<Option<u32>> {
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
        let mut exposed = Vec::new();
        let per_cell = self.tetrahedra_per_cell() as u32;
        let mut leaves = std::mem::take(&mut table.leaves);
        for (tetrahedron, others) in table.neighbours.iter().enumerate().filter(|(e, _)| !has_failed[*e]) {
            for (face, other) in FACES.iter().zip(others) {
                if *other != NO_NEIGHBOUR && has_failed[*other as usize] {
                    let corners = face.map(|corner| nodes[tetrahedron][corner]);
                    let cell = tetrahedron as u32 / per_cell;
                    let polygon = self.clip(&table, corners, &mut leaves);
                    exposed.extend((2..polygon.len()).map(|i| ([polygon[0], polygon[i - 1], polygon[i]], cell)));
                }
            }
        }
        table.leaves = leaves;
        self.failed.table = Some(table);
        for (_, cell) in &exposed {
            // Contact looks for the surface in cells of this state alone.
            let state = &mut self.region.cell_state[*cell as usize];
            if u32::from(*state) != abi::CELL_SURFACE {
                self.failed.exposed.push((*cell, std::mem::replace(state, abi::CELL_SURFACE as u8)));
            }
        }
        Ok(BrokenSurface { is_gone, exposed })
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
        let surface = if is_of_file { None } else { MeshSurface::new(&model.surface, 0.0).ok() };
        let is_inside = surface.as_ref().map_or_else(Vec::new, |surface| {
            let nodes = 0..self.region.node_id.len() as u32;
            nodes.map(|n| surface.nearest(self.grid_rest(n)).distance <= ON_SURFACE * self.edge()).collect()
        });
        Ok(FaceTable {
            nodes: nodes.to_vec(),
            neighbours: neighbours(nodes),
            triangles,
            passes,
            starts,
            is_inside,
            surface,
            leaves: BTreeMap::new(),
        })
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
