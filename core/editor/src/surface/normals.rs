//! Normals of drawn vertices: the mean over the triangles of their group, weighted by their angles at the vertex (Thuermer and Wuethrich 1998), which a cut
//! through one of the triangles does not change.

use super::ViewSurface;
use pliant_solver::Vec3;

impl ViewSurface {
    /// Normal of a triangle whose length is twice the area, m^2; zero if it is invisible.
    pub(super) fn cross(&self, triangle: u32) -> Vec3 {
        let Some(look) = self.triangles[triangle as usize] else { return Vec3::zeros() };
        let [a, b, c] = look.corners.map(|vertex| self.place(vertex));
        (b - a).cross(&(c - a))
    }

    /// Updates the normals of all drawn vertices of a mesh vertex.
    pub(super) fn update_normals(&mut self, vertex: u32) {
        let (first, count) = self.span_of[vertex as usize];
        for drawn in first..first + count {
            let of_faces = self.mean_normal(vertex, drawn).try_normalize(0.0).unwrap_or_default();
            let unit = self.turned_normal(vertex, drawn, of_faces).unwrap_or(of_faces);
            self.normals[drawn as usize] = unit.map(|c| c as f32).into();
        }
    }

    /// Sum of the unit normals of the triangles of a drawn vertex's group, each times its angle at the vertex.
    pub(super) fn mean_normal(&self, vertex: u32, drawn: u32) -> Vec3 {
        let (first, count) = self.span_of[vertex as usize];
        let group = self.drawn[drawn as usize].group;
        let mut sum = Vec3::zeros();
        for &triangle in self.around.of(vertex) {
            let corners = self.corners[triangle as usize];
            let in_group =
                |corner: &u32| (first..first + count).contains(corner) && self.drawn[*corner as usize].group == group;
            if let Some(corner) = corners.iter().position(in_group) {
                sum += self.angle(triangle, corner) * self.cross(triangle).try_normalize(0.0).unwrap_or_default();
            }
        }
        sum
    }

    /// Angle of a triangle at one of its corners, radians; 0 if it is degenerate.
    fn angle(&self, triangle: u32, corner: usize) -> f64 {
        let Some(look) = self.triangles[triangle as usize] else { return 0.0 };
        let place = |corner: usize| self.place(look.corners[corner % 3]);
        let [to_next, to_last] = [1, 2].map(|other| place(corner + other) - place(corner));
        to_next.cross(&to_last).norm().atan2(to_next.dot(&to_last))
    }
}
