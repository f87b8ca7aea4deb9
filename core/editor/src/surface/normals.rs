//! Normals of drawn vertices: the area-weighted mean over the triangles of their group.

use super::ViewSurface;
use pliant_solver::Vec3;

impl ViewSurface {
    /// Normal of a triangle whose length is twice the area, m^2; zero if it is invisible.
    pub(super) fn cross(&self, triangle: u32) -> Vec3 {
        let Some(look) = self.triangles[triangle as usize] else { return Vec3::zeros() };
        let place = |corner: usize| {
            let [x, y, z] = self.positions[look.corners[corner] as usize].map(f64::from);
            Vec3::new(x, y, z)
        };
        let a = place(0);
        (place(1) - a).cross(&(place(2) - a))
    }

    /// Updates the normals of all drawn vertices of a mesh vertex.
    pub(super) fn update_normals(&mut self, vertex: u32) {
        let (first, count) = self.span_of[vertex as usize];
        for drawn in first..first + count {
            let group = self.drawn[drawn as usize].group;
            let mut sum = Vec3::zeros();
            for &triangle in self.around.of(vertex) {
                let corners = self.corners[triangle as usize];
                let in_group = |corner: &u32| {
                    (first..first + count).contains(corner) && self.drawn[*corner as usize].group == group
                };
                if corners.iter().any(in_group) {
                    sum += self.cross(triangle);
                }
            }
            let unit = sum.try_normalize(0.0).unwrap_or_default();
            self.normals[drawn as usize] = unit.map(|c| c as f32).into();
        }
    }
}
