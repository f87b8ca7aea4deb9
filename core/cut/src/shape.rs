//! An advance in another shape of the mesh than the one at rest.

use super::advance::Advance;
use super::blade::{Blade, Stroke};
use super::error::Refused;
use super::mesh::CutMesh;
use super::record::Origin;
use pliant_mesh::geometry::{TriangleTree, Vec3};

impl CutMesh {
    /// Cuts a sheet as [`CutMesh::advance`] does, but in the shape in which its vertices are at `points` (m, one for each): blade and stroke are in that
    /// shape, and so are the length and the facets of the advance. `points` gets the positions of new vertices; at rest these divide the same edges and
    /// triangles in the same ratios. The cost is linear in the size of the mesh.
    ///
    /// # Errors
    /// As for [`CutMesh::advance`]. The mesh, the stroke and `points` are unchanged.
    pub fn advance_in_shape(
        &mut self,
        points: &mut Vec<Vec3>,
        stroke: &mut Stroke,
        next: Blade,
    ) -> Result<Advance, Refused> {
        let tree = TriangleTree::new(points, &self.surface.triangles);
        let tree_at_rest = std::mem::replace(&mut self.tree, tree);
        std::mem::swap(&mut self.surface.points, points);
        let advance = self.advance(stroke, next);
        std::mem::swap(&mut self.surface.points, points);
        self.tree = tree_at_rest;
        let advance = advance?;
        for vertex in advance.first_vertex..points.len() as u32 {
            let at = |v: u32| self.point(v);
            let place = match self.origin(vertex) {
                Origin::Edge { ends: [a, b], t } => at(a) + t * (at(b) - at(a)),
                Origin::Face { corners: [a, b, c], weights } => {
                    weights[0] * at(a) + weights[1] * at(b) + weights[2] * at(c)
                }
                Origin::Copy { of } => at(of),
                // A sheet has no walls.
                Origin::Original | Origin::Cap { .. } => points[vertex as usize],
            };
            self.surface.points.push(place);
        }
        let new = advance.first_triangle..self.surface.triangles.len() as u32;
        for triangle in advance.changed.iter().copied().chain(new) {
            self.tree.set(triangle, self.corners_of(triangle));
        }
        Ok(advance)
    }
}
