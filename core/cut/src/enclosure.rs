//! Point-in-body queries.

use super::mesh::CutMesh;
use super::parts::BodyPart;
use super::record::OPEN;
use super::solid::{RAYS, crossing, end};
use pliant_mesh::geometry::Vec3;
use std::collections::BTreeSet;

impl CutMesh {
    /// Corners (m) of the triangles, without cut surfaces, whose boxes intersect the box around `centre` with the half-size `reach` (both in m).
    pub fn triangles_near(&self, centre: Vec3, reach: f64) -> Vec<[Vec3; 3]> {
        let mut found = Vec::new();
        self.tree.near(centre, reach, |triangle| {
            if !self.is_cap(triangle) {
                found.push(self.corners_of(triangle));
            }
        });
        found
    }

    /// Whether a point (m) is inside of a closed body.
    pub fn encloses(&self, place: Vec3) -> bool {
        self.bodies_around(place).is_some_and(|around| !around.is_empty())
    }

    /// Nonzero winding numbers of bodies around a point (m), by body. `None` if every ray hits an edge.
    pub(super) fn bodies_around(&self, point: Vec3) -> Option<Vec<(u32, i32)>> {
        self.windings(point, |triangle| self.body[triangle as usize])
    }

    /// The parts of closed bodies that are around a point (m), ascending. `part_of` is as [`CutMesh::body_parts`] gives it. Empty outside of all, and where every
    /// ray hits an edge.
    pub fn parts_around(&self, point: Vec3, part_of: &[Option<BodyPart>]) -> Vec<BodyPart> {
        let around = self.windings(point, |triangle| part_of[triangle as usize]).unwrap_or_default();
        around.into_iter().filter_map(|(part, _)| part).collect()
    }

    /// The parts of closed bodies with triangles whose boxes intersect the box around `centre` with the half-size `reach` (both in m), ascending. `part_of` is as
    /// [`CutMesh::body_parts`] gives it.
    pub fn parts_near(&self, centre: Vec3, reach: f64, part_of: &[Option<BodyPart>]) -> Vec<BodyPart> {
        let mut parts = BTreeSet::new();
        self.tree.near(centre, reach, |triangle| parts.extend(part_of[triangle as usize]));
        parts.into_iter().collect()
    }

    /// Nonzero winding numbers around a point (m) of sets of triangles in closed bodies: those that have the same key. `None` if every ray hits an edge.
    fn windings<K: Copy + Ord>(&self, point: Vec3, key: impl Fn(u32) -> K) -> Option<Vec<(K, i32)>> {
        'rays: for ray in RAYS {
            let far = end(point, ray, self.uncut.reach);
            let mut around: Vec<(K, i32)> = Vec::new();
            let mut hits = Vec::new();
            self.tree.along(point, far, |triangle| hits.push(triangle));
            for triangle in hits.into_iter().filter(|&triangle| self.body[triangle as usize] != OPEN) {
                let Some(crossing) = crossing(self.corners_of(triangle), point, far) else { continue 'rays };
                let key = key(triangle);
                match around.iter_mut().find(|(known, _)| *known == key) {
                    Some((_, winding)) => *winding += crossing,
                    None => around.push((key, crossing)),
                }
            }
            around.retain(|(_, winding)| *winding != 0);
            around.sort_unstable();
            return Some(around);
        }
        None
    }
}
