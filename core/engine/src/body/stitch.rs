//! Stitching of a body: nodes that face each other across a cut, or on two borders of a sheet, become one.

use super::{Body, Discretization, LatticeError};
use pliant_solver::Vec3;
use std::sync::Arc;

/// Largest distance at which nodes are joined, in edges of the discretization.
const JOIN_DISTANCE: f64 = 0.25;

/// What a stitch has found.
#[derive(Clone, Debug, Default)]
pub struct Stitched {
    /// Whether nodes have been joined. Nodes then have other numbers from the next change of the body on.
    pub has_joined: bool,
    /// Pairs of nodes that face each other and are too far apart to be joined.
    pub apart: Vec<[u32; 2]>,
}

impl Body {
    /// Joins nodes that face each other within `radius` (m) of a point of the rest shape (m), where they are near enough.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin; a sheet is then as it was before.
    pub fn stitch(&mut self, point: Vec3, radius: f64) -> Result<Stitched, LatticeError> {
        let centre = self.embed_point(point)?.now;
        let join = Self::join_distance(self.discretization.edge());
        let Discretization::Sheet(sheet) = &self.discretization else { return self.heal(point, radius, join) };
        let pairs = sheet.facing_nodes(&self.model, &self.system.nodes, centre, radius, join);
        let x = &self.system.nodes.x;
        let is_near = |[a, b]: &[u32; 2]| (x[*a as usize] - x[*b as usize]).norm() <= join;
        let (near, apart): (Vec<_>, Vec<_>) = pairs.into_iter().partition(is_near);
        if near.is_empty() {
            return Ok(Stitched { has_joined: false, apart });
        }
        self.join_nodes(&near)?;
        Ok(Stitched { has_joined: true, apart: Vec::new() })
    }

    /// Largest distance (m) at which nodes are joined, on a body with edges of this length (m).
    pub fn join_distance(edge: f64) -> f64 {
        JOIN_DISTANCE * edge
    }

    /// Makes each pair of nodes of a sheet, lower number first and no node in two pairs, one node.
    ///
    /// # Errors
    /// Returns the error of the material; the sheet is then as it was before.
    pub(crate) fn join_nodes(&mut self, pairs: &[[u32; 2]]) -> Result<(), LatticeError> {
        let state = self.save();
        if let Discretization::Sheet(sheet) = &mut self.discretization
            && let Err(refused) = sheet.weld(pairs, &self.model, &mut self.system)
        {
            self.restore(&state)?;
            return Err(refused);
        }
        self.settle_welds();
        Ok(())
    }

    /// Pairs of vertices that are connected other than by triangles: by stitches, as welded ones of a sheet and some on both faces of what has healed in a
    /// solid; and around a hollow where elements of a solid have failed.
    pub fn joined_vertices(&self) -> Vec<[u32; 2]> {
        match &self.discretization {
            Discretization::Lattice(lattice) => {
                let mut pairs = lattice.healed_pairs();
                pairs.extend(self.vertices_of_one_part());
                pairs
            }
            Discretization::Sheet(sheet) => sheet.welds().iter().map(|(vertex, of)| [*vertex, *of]).collect(),
        }
    }

    /// Part of each triangle of its surface: triangles connected by common vertices or by stitches have one number, counted from 0 in the order of the first
    /// triangles. Triangles that have failed have [`NO_SHELL`](pliant_mesh::NO_SHELL), and connect nothing.
    pub fn parts(&self) -> Vec<u32> {
        self.model.surface.joined_shells(&self.joined_vertices(), |t| self.failed_triangles.contains(t))
    }

    /// Moves the vertices of a sheet to their nodes, at rest and at present, after vertices have been welded.
    fn settle_welds(&mut self) {
        let Discretization::Sheet(sheet) = &self.discretization else { return };
        let settled = Arc::make_mut(&mut self.skin.settled);
        let mut moved: Vec<u32> = Vec::new();
        for (&vertex, &of) in sheet.welds() {
            let rest = self.system.nodes.rest[sheet.node_of(of) as usize];
            for v in [vertex, of] {
                if settled[v as usize] != rest {
                    settled[v as usize] = rest;
                    moved.extend_from_slice(self.model.around(v));
                }
            }
        }
        moved.sort_unstable();
        moved.dedup();
        Arc::make_mut(&mut self.skin.tree).refit(&self.skin.settled, &self.model.surface.triangles, &moved);
        sheet.embed(&self.system.nodes, &mut self.skin);
    }
}
