//! Edges for a wireframe: those of the file's polygons, without the diagonals of their triangulation.

use super::ViewSurface;
use pliant_engine::body::{CAP, TriangleLook};

impl ViewSurface {
    /// Drawn vertices at the ends of every edge between two polygons or on a border (e x 2).
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::with_capacity(self.triangles.len() * 3 / 2);
        for (triangle, look) in self.triangles.iter().enumerate() {
            let Some(look) = look else { continue };
            for corner in 0..3 {
                let (from, to) = (look.corners[corner], look.corners[(corner + 1) % 3]);
                let across = self.around.of(from).iter().copied().find(|other| {
                    let other_look = self.triangles[*other as usize].as_ref();
                    *other as usize != triangle && other_look.is_some_and(|other| other.corners.contains(&to))
                });
                let other_face = across.and_then(|t| self.triangles[t as usize].as_ref()).map(|other| other.face);
                // Each edge is listed once, from the triangle with the lower index.
                let first = across.is_none_or(|other| triangle < other as usize);
                if first && other_face.is_none_or(|face| face != look.face) {
                    let corners = self.corners[triangle];
                    edges.push([corners[corner], corners[(corner + 1) % 3]]);
                }
            }
        }
        edges
    }

    /// Mesh vertices at the ends of every edge that a cut has made on the surface: where that meets the faces inside, or the border of a cut sheet (e x 2).
    pub fn cut_edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::new();
        for (triangle, look) in self.triangles.iter().enumerate() {
            let Some(look) = look else { continue };
            let is_cap = look.material == CAP;
            for corner in 0..3 {
                let ends = [look.corners[corner], look.corners[(corner + 1) % 3]];
                if !is_cap && ends.iter().all(|vertex| (*vertex as usize) < self.opened) {
                    continue;
                }
                let across = self.across(triangle, ends);
                if across.map_or(!is_cap, |other| is_cap && other.material != CAP) {
                    edges.push(ends);
                }
            }
        }
        edges
    }

    /// The triangle on the other side of an edge of a triangle.
    fn across(&self, triangle: usize, [from, to]: [u32; 2]) -> Option<&TriangleLook> {
        let others = self.around.of(from).iter().filter(|other| **other as usize != triangle);
        others.filter_map(|other| self.triangles[*other as usize].as_ref()).find(|other| other.corners.contains(&to))
    }
}
