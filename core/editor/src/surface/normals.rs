//! Normals of drawn vertices: the mean over the triangles of their group, weighted by their angles at the vertex (Thuermer and Wuethrich 1998), which a cut
//! through one of the triangles does not change.

use super::ViewSurface;
use pliant_solver::Vec3;

/// What a triangle adds to the normals at its corners. It is kept, because each of its three corners needs it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Facet {
    /// Unit normal; zero if the triangle is invisible or degenerate.
    normal: [f32; 3],
    /// Angles at the corners, radians.
    angles: [f32; 3],
}

impl ViewSurface {
    /// Normal of a triangle whose length is twice the area, m^2; zero if it is invisible.
    pub(super) fn cross(&self, triangle: u32) -> Vec3 {
        let Some(look) = self.triangles[triangle as usize] else { return Vec3::zeros() };
        let [a, b, c] = look.corners.map(|vertex| self.place(vertex));
        (b - a).cross(&(c - a))
    }

    /// Computes the facet of a triangle again.
    pub(super) fn update_facet(&mut self, triangle: u32) {
        self.facets[triangle as usize] = self.facet(triangle).unwrap_or_default();
    }

    /// The facet of a triangle; `None` if that is invisible or degenerate.
    fn facet(&self, triangle: u32) -> Option<Facet> {
        let corners = self.triangles[triangle as usize]?.corners.map(|vertex| self.place(vertex));
        let edges = [0, 1, 2].map(|corner: usize| corners[(corner + 1) % 3] - corners[corner]);
        let cross = edges[0].cross(&edges[1]);
        let area = cross.norm();
        // The cross product of the edges has the same length at each corner.
        let angle = |corner: usize| area.atan2(-edges[corner].dot(&edges[(corner + 2) % 3]));
        let first_two = [angle(0), angle(1)];
        let angles = [first_two[0], first_two[1], std::f64::consts::PI - first_two[0] - first_two[1]];
        (area > 0.0)
            .then(|| Facet { normal: (cross / area).map(|c| c as f32).into(), angles: angles.map(|a| a as f32) })
    }

    /// Updates the normals of all drawn vertices of a mesh vertex from the facets of its triangles.
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
                let Facet { normal, angles } = self.facets[triangle as usize];
                sum += f64::from(angles[corner]) * Vec3::from(normal.map(f64::from));
            }
        }
        sum
    }
}
