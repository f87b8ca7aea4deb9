//! Normals beside a cut: the surface is shaded there as it was before.
//!
//! Vertices that a cut adds lie in the flat faces of the model. The mean of the faces around such a vertex is not what was shown there, which is
//! interpolated from the corners of the face. The normal that was shown is kept in axes of the faces around the vertex, so that it turns with them.

use super::ViewSurface;
use nalgebra::Matrix3;
use pliant_engine::body::CAP;
use pliant_solver::Vec3;
use std::collections::HashMap;

/// The normal that was shown at a vertex before it was at a cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct KeptNormal {
    /// A triangle of the group that has the normal.
    triangle: u32,
    /// Components along the axes of the group.
    local: Vec3,
}

/// Triangles that a patch takes away, by the face of the document they are a part of.
#[derive(Default)]
pub(super) struct ShownBefore(HashMap<u32, Vec<ShownTriangle>>);

/// A triangle as it was shown.
struct ShownTriangle {
    corners: [Vec3; 3],
    normals: [Vec3; 3],
}

/// Cosine of the angle between the normal of the faces and the kept one below which that is not used: they belong to different shapes.
const SAME_SHAPE: f64 = 0.5;

impl ShownBefore {
    /// The normal that was shown at a place of a face, m; `None` if no triangle of the face was.
    fn normal_at(&self, face: u32, place: Vec3) -> Option<Vec3> {
        let of_face = self.0.get(&face)?.iter().filter_map(|triangle| {
            let weights = barycentric(&triangle.corners, place)?;
            let normal: Vec3 = (0..3).map(|i| weights[i].max(0.0) * triangle.normals[i]).sum();
            Some((weights.min(), normal.try_normalize(1e-9)?))
        });
        of_face.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, normal)| normal)
    }
}

impl ViewSurface {
    /// Notes how a triangle is shown.
    pub(super) fn note_shown(&self, triangle: u32, before: &mut ShownBefore) {
        let Some(look) = self.triangles[triangle as usize].filter(|look| look.material != CAP) else { return };
        let is_there = |vertex: &u32| (*vertex as usize) < self.positions.len();
        if look.corners.iter().all(is_there) {
            let normals =
                self.corners[triangle as usize].map(|drawn| Vec3::from(self.normals[drawn as usize].map(f64::from)));
            let corners = look.corners.map(|vertex| self.place(vertex));
            before.0.entry(look.face).or_default().push(ShownTriangle { corners, normals });
        }
    }

    /// Keeps the normals that were shown at vertices of a patch that are at a cut now, and forgets those of the others.
    pub(super) fn keep_normals(&mut self, vertices: &[u32], before: &ShownBefore) {
        for &vertex in vertices {
            self.kept_normals.remove(&vertex);
            let kept: Vec<KeptNormal> =
                self.groups_at_cut(vertex).filter_map(|t| self.kept(vertex, t, before)).collect();
            if !kept.is_empty() {
                self.kept_normals.insert(vertex, kept);
            }
        }
        let count = self.positions.len();
        self.kept_normals.retain(|vertex, _| (*vertex as usize) < count);
    }

    /// A triangle for each group around a vertex that is at a cut or was made by one, but for the cut surface itself.
    fn groups_at_cut(&self, vertex: u32) -> impl Iterator<Item = u32> + use<'_> {
        let around = self.around.of(vertex);
        let material = |triangle: &u32| self.triangles[*triangle as usize].map(|look| look.material);
        let is_at_cut = vertex as usize >= self.opened || around.iter().any(|t| material(t) == Some(CAP));
        let mut groups: Vec<u32> = Vec::new();
        around.iter().copied().filter(move |triangle| {
            if !is_at_cut || material(triangle).is_none_or(|material| material == CAP) {
                return false;
            }
            let Some(drawn) = self.drawn_at(*triangle, vertex) else { return false };
            let group = self.drawn[drawn as usize].group;
            let is_new = !groups.contains(&group);
            groups.push(group);
            is_new
        })
    }

    fn kept(&self, vertex: u32, triangle: u32, before: &ShownBefore) -> Option<KeptNormal> {
        let face = self.triangles[triangle as usize]?.face;
        let normal = before.normal_at(face, self.place(vertex))?;
        let of_faces = self.mean_normal(vertex, self.drawn_at(triangle, vertex)?).try_normalize(0.0)?;
        let local = self.axes_at(vertex, triangle, of_faces)?.transpose() * normal;
        (local.z >= SAME_SHAPE).then_some(KeptNormal { triangle, local })
    }

    /// The kept normal of a drawn vertex whose faces have the unit normal `of_faces`, as it has turned with them; `None` without one.
    pub(super) fn turned_normal(&self, vertex: u32, drawn: u32, of_faces: Vec3) -> Option<Vec3> {
        let group = self.drawn[drawn as usize].group;
        let of_group = |kept: &&KeptNormal| {
            self.drawn_at(kept.triangle, vertex).is_some_and(|other| self.drawn[other as usize].group == group)
        };
        let kept = self.kept_normals.get(&vertex)?.iter().find(of_group)?;
        Some(self.axes_at(vertex, kept.triangle, of_faces)? * kept.local)
    }

    /// The drawn vertex of a triangle at a mesh vertex.
    fn drawn_at(&self, triangle: u32, vertex: u32) -> Option<u32> {
        let look = self.triangles.get(triangle as usize)?.as_ref()?;
        let corner = look.corners.iter().position(|other| *other == vertex)?;
        Some(self.corners[triangle as usize][corner])
    }

    /// Axes at a vertex that turn with a triangle there: its edge from the vertex, square to the unit normal, across that, and the normal.
    fn axes_at(&self, vertex: u32, triangle: u32, normal: Vec3) -> Option<Matrix3<f64>> {
        let look = self.triangles[triangle as usize]?;
        let corner = look.corners.iter().position(|other| *other == vertex)?;
        let edge = self.place(look.corners[(corner + 1) % 3]) - self.place(vertex);
        let along = (edge - edge.dot(&normal) * normal).try_normalize(0.0)?;
        Some(Matrix3::from_columns(&[along, normal.cross(&along), normal]))
    }
}

/// Barycentric coordinates of the projection of a point onto a triangle; `None` for a degenerate one.
fn barycentric(corners: &[Vec3; 3], point: Vec3) -> Option<Vec3> {
    let [a, b, c] = *corners;
    let normal = (b - a).cross(&(c - a));
    let area = normal.norm_squared();
    let share = |from: Vec3, to: Vec3| (to - from).cross(&(point - from)).dot(&normal) / area;
    (area > 0.0).then(|| Vec3::new(share(b, c), share(c, a), share(a, b)))
}
