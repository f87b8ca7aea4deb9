//! Splitting of mesh vertices into drawn vertices at hard edges, texture seams and material boundaries.

use super::ViewSurface;
use pliant_engine::body::{ABSENT, CAP, TriangleLook};

/// A drawn vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnVertex {
    /// Index of the mesh vertex.
    pub vertex: u32,
    /// Group of triangles around the vertex that share a normal, numbered at each vertex.
    pub(super) group: u32,
    /// Texture coordinates; 0 if there are none.
    pub texture: [f32; 2],
    /// Index into the materials of the document, [`CAP`], or [`ABSENT`].
    pub material: u32,
}

/// Cosine of the angle between triangles above which their edge is hard, for models without normals: 50 degrees, so that an eight-sided cylinder is smooth and
/// a cube is not.
const HARD_EDGE: f64 = 0.642_787_609_686_539_3;

impl ViewSurface {
    /// Computes the drawn vertices of a mesh vertex again. They keep their indices if their number is unchanged.
    pub(super) fn split(&mut self, vertex: u32) {
        let around = self.around.of(vertex).to_vec();
        let groups = self.normal_groups(vertex, &around);
        let mut found: Vec<DrawnVertex> = Vec::with_capacity(1);
        let mut of_corner = Vec::with_capacity(around.len());
        for (triangle, group) in around.iter().zip(groups) {
            let Some(look) = self.triangles[*triangle as usize] else { continue };
            let Some(corner) = look.corners.iter().position(|v| *v == vertex) else { continue };
            let drawn = DrawnVertex { vertex, group, texture: look.texture[corner], material: look.material };
            let at = found.iter().position(|other| same(other, &drawn)).unwrap_or_else(|| {
                found.push(drawn);
                found.len() - 1
            });
            of_corner.push((*triangle, corner, at as u32));
        }
        if found.is_empty() {
            // A vertex without triangles still gets one index, so that indices stay dense.
            found.push(DrawnVertex { vertex, group: 0, texture: [0.0; 2], material: ABSENT });
        }
        let (first, count) = self.span_of[vertex as usize];
        let first = if count as usize == found.len() {
            self.drawn[first as usize..(first + count) as usize].copy_from_slice(&found);
            first
        } else {
            let first = self.drawn.len() as u32;
            self.drawn.extend_from_slice(&found);
            first
        };
        self.span_of[vertex as usize] = (first, found.len() as u32);
        for (triangle, corner, at) in of_corner {
            self.corners[triangle as usize][corner] = first + at;
        }
    }

    /// For each triangle around a vertex, the group of triangles with which it shares a normal there: by the file's normals if there are any, otherwise by hard
    /// edges. A cut surface never shares a normal with the outer surface.
    fn normal_groups(&self, vertex: u32, around: &[u32]) -> Vec<u32> {
        let looks: Vec<Option<&TriangleLook>> = around.iter().map(|t| self.triangles[*t as usize].as_ref()).collect();
        let shading = |look: &TriangleLook| {
            let corner = look.corners.iter().position(|v| *v == vertex)?;
            Some(look.shading[corner]).filter(|row| *row != ABSENT)
        };
        let rows: Vec<Option<u32>> = looks.iter().map(|look| look.and_then(shading)).collect();
        let mut group: Vec<u32> = (0..around.len() as u32).collect();
        let crosses: Vec<_> = around.iter().map(|t| self.cross(*t)).collect();
        for first in 0..around.len() {
            for second in first + 1..around.len() {
                let (Some(a), Some(b)) = (looks[first], looks[second]) else { continue };
                if group[first] == group[second] || (a.material == CAP) != (b.material == CAP) {
                    continue;
                }
                let joined = match (rows[first], rows[second]) {
                    (Some(a), Some(b)) => a == b,
                    (None, None) => {
                        let shares_edge = a.corners.iter().filter(|v| b.corners.contains(v)).count() > 1;
                        let (a, b) = (crosses[first], crosses[second]);
                        shares_edge && a.dot(&b) >= HARD_EDGE * a.norm() * b.norm()
                    }
                    _ => false,
                };
                if joined {
                    let (from, to) = (group[second], group[first]);
                    group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
                }
            }
        }
        group
    }
}

/// Whether two corners share a drawn vertex.
fn same(a: &DrawnVertex, b: &DrawnVertex) -> bool {
    a.group == b.group && a.material == b.material && a.texture == b.texture
}
