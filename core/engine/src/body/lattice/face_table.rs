//! What follows from the tetrahedra of a lattice and the surface in them, whichever of them have failed.

use super::{Lattice, LatticeError};
use crate::body::model::Model;
use crate::contact::{SKIN_DEPTH, inward};
use crate::obstacle::MeshSurface;
use pliant_cut::carve::jitter;
use pliant_mesh::Surface;
use pliant_mesh::tetrahedra::neighbours;
use pliant_solver::Vec3;
use std::collections::BTreeMap;

/// Distance from the surface, in edges of a cell, up to which a node counts as inside of the body.
pub(super) const ON_SURFACE: f64 = 1e-6;
/// Depth under the surface at which it is carved, in edges of a cell.
const CARVED_DEPTH: f64 = 1e-5;
/// Spacing of the points of a triangle at which the tetrahedra it passes through are looked up, in edges of a cell.
const SPACING: f64 = 0.5;

/// What follows from the tetrahedra and the surface, whichever of them have failed; made when the active cells are, for it takes many steps' time.
pub(super) struct FaceTable {
    /// Nodes of the tetrahedra it was made for (m x 4).
    pub(super) nodes: Vec<[u32; 4]>,
    /// The tetrahedron on the other side of each face (m x 4).
    pub(super) neighbours: Vec<[u32; 4]>,
    /// Number of triangles it was made for.
    pub(super) triangles: usize,
    /// Tetrahedra that triangle t of the surface passes through: `passes[starts[t]..starts[t + 1]]`.
    passes: Vec<u32>,
    starts: Vec<u32>,
    /// Whether each node is inside of the body; empty where all are, as in the tetrahedra of a file.
    pub(super) is_inside: Vec<bool>,
    /// The surface of the file, for cubes that reach out of it.
    pub(super) surface: Option<MeshSurface>,
    /// Vertices of the surface, moved inwards by a little, and positions of the nodes in general position, m; empty where the surface is not carved.
    pub(super) carved: [Vec<Vec3>; 2],
    /// Where edges that have been asked for go through it, as a share of the way from the lower node.
    pub(super) leaves: BTreeMap<[u32; 2], f64>,
}

impl FaceTable {
    /// Tetrahedra that triangle `t` of the surface passes through.
    pub(super) fn passed(&self, t: usize) -> &[u32] {
        &self.passes[self.starts[t] as usize..self.starts[t + 1] as usize]
    }
}

impl Lattice {
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
            let point = inward(weights[0] * a + weights[1] * b + weights[2] * c, normal, SKIN_DEPTH * self.edge());
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
