//! Normals of the deformed surface.

use std::iter::zip;

use super::mesh::CutMesh;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::obj::{ShadedCorner, TurnedNormals};

impl CutMesh {
    /// Rows of [`CutMesh::normals`] with the vertices of [`CutMesh::surface`] at `points` (n x 3, m), in axes of the file. Normals of triangles that
    /// have not moved keep every bit.
    pub fn turned_normals(&self, points: &[Vec3]) -> TurnedNormals {
        let seen = (0..self.surface.triangles.len() as u32).filter(|&t| !self.is_lid(t));
        let faces: Vec<Vec<ShadedCorner>> = seen.map(|t| self.shaded(t).to_vec()).collect();
        let axes = self.placement.rotation; // from axes of the file to those of the points
        let placed: Vec<Vec3> = self.normals.iter().map(|normal| axes * normal).collect();
        let mut turned = TurnedNormals::new(&placed, &faces, &self.surface.points, points);
        for (row, (placed, own)) in zip(&mut turned.rows, zip(&placed, &self.normals)) {
            *row = if row == placed { *own } else { axes.inverse() * *row };
        }
        turned.added.iter_mut().for_each(|row| *row = axes.inverse() * *row);
        turned
    }

    /// Vertex and row of the normal at each corner of a triangle.
    pub(super) fn shaded(&self, triangle: u32) -> [ShadedCorner; 3] {
        let record = self.triangle(triangle);
        [0, 1, 2].map(|corner| [record.corners[corner], record.shading[corner]])
    }
}
