//! Tetrahedra of a lattice that have failed (`pliant.failure/1`): which triangles of the surface they carried, and which faces of others come to light.
//!
//! A cube of a grid falls into five tetrahedra, of which some may have failed. What lies in such a cube follows the tetrahedron around it and not
//! all eight corners, some of which may hang on nothing any more.

use super::Lattice;
use super::face_table::FaceTable;
use pliant_mesh::DisjointSets;
use pliant_solver::Vec3;

/// The tetrahedra that have failed.
#[derive(Default)]
pub(super) struct FailedCells {
    /// Whether each tetrahedron has failed; empty if none has (m).
    pub(super) has_failed: Vec<bool>,
    /// Vertices of the surface whose triangles are all gone, ascending.
    loose: Vec<u32>,
    /// Active cells in which faces have come to light, with the state that each had before.
    pub(super) exposed: Vec<(u32, u8)>,
    pub(super) table: Option<Box<FaceTable>>,
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
    pub(super) fn tetrahedron_in(
        &self,
        cell: u32,
        place: Vec3,
        is_wanted: impl Fn(usize) -> bool,
    ) -> Option<(usize, [f64; 4])> {
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
    pub(super) fn vertices_of_nodes(&self) -> Vec<Option<u32>> {
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
        let node_of =
            |t: usize| table.passed(t).first().filter(|e| !has_failed(**e)).map(|e| table.nodes[*e as usize][0]);
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
}
