//! The normals of a cut model that has been deformed.

use std::iter::zip;

use nalgebra::UnitQuaternion;

use super::mesh::{CutMesh, NONE};
use pliant_mesh::geometry::Vec3;

impl CutMesh {
    /// The rows of [`CutMesh::normals`] with the vertices at `points` (n x 3, m): each turned as the triangles that name it
    /// are, on average by area. A row whose triangles did not move keeps its bits.
    ///
    /// # Panics
    /// When `points` has fewer rows than the surface.
    pub fn turned_normals(&self, points: &[Vec3]) -> Vec<Vec3> {
        let mut around = vec![[Vec3::zeros(); 2]; self.normals.len()]; // area at rest and now
        let mut moved = vec![false; self.normals.len()];
        for (number, (corners, rows)) in zip(&self.surface.triangles, &self.shading).enumerate() {
            let [a, b, c] = corners.map(|vertex| points[vertex as usize]);
            let areas = [self.cross(number as u32), (b - a).cross(&(c - a))];
            let still = corners.iter().all(|&vertex| points[vertex as usize] == self.surface.points[vertex as usize]);
            for &row in rows.iter().filter(|&&row| row != NONE) {
                moved[row as usize] |= !still;
                (0..2).for_each(|i| around[row as usize][i] += areas[i]);
            }
        }
        let axes = self.placement.rotation; // of the file to those of the points
        let turned = |(normal, ([rest, now], moved)): (&Vec3, ([Vec3; 2], bool))| {
            let turn = if moved { UnitQuaternion::rotation_between(&rest, &now) } else { None };
            turn.map_or(*normal, |turn| axes.inverse() * (turn * (axes * *normal)))
        };
        zip(&self.normals, zip(around, moved)).map(turned).collect()
    }
}
