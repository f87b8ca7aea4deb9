//! Point-in-body queries.

use super::mesh::CutMesh;
use super::parts::BodyPart;
use super::record::OPEN;
use super::solid::{RAYS, crossing, end};
use pliant_mesh::geometry::Vec3;
use std::collections::BTreeSet;

impl CutMesh {
    /// Corners (m) of the triangles, without cut surfaces, whose boxes intersect the box around `centre` with the half-size `reach` (both in m), in the order of
    /// their numbers.
    pub fn triangles_near(&self, centre: Vec3, reach: f64) -> Vec<[Vec3; 3]> {
        let mut found = Vec::new();
        self.tree.near(centre, reach, |triangle| {
            if !self.is_cap(triangle) {
                found.push(triangle);
            }
        });
        found.sort_unstable();
        found.into_iter().map(|triangle| self.corners_of(triangle)).collect()
    }

    /// Whether a point (m) is inside of a closed body.
    pub fn encloses(&self, place: Vec3) -> bool {
        self.bodies_around(place).is_some_and(|around| !around.is_empty())
    }

    /// Nonzero winding numbers of bodies around a point (m), by body. `None` if every ray hits an edge.
    pub(super) fn bodies_around(&self, point: Vec3) -> Option<Vec<(u32, i32)>> {
        self.windings(point, |triangle| self.body[triangle as usize])
    }

    /// The parts of closed bodies that are around each of some points (m), ascending. `part_of` is as [`CutMesh::body_parts`] gives it. Empty outside of all, and
    /// where every ray hits an edge. Winding numbers of a point are those of the one before it and the crossings between the two, so points in a row should be close to each other.
    pub fn parts_around(&self, points: &[Vec3], part_of: &[Option<BodyPart>]) -> Vec<Vec<BodyPart>> {
        let key = |triangle: u32| part_of[triangle as usize];
        let mut last = None;
        // Points with no surface between them are in the same parts.
        let counted = if self.is_free_between(points) { &points[..1] } else { points };
        let around = counted.iter().map(|&point| {
            let onward = last.take().and_then(|(from, around)| self.add_crossings(around, [point, from], key));
            let around = onward.or_else(|| self.windings(point, key));
            last = around.clone().map(|around| (point, around));
            around.unwrap_or_default().into_iter().filter_map(|(part, _)| part).collect()
        });
        let mut around: Vec<Vec<BodyPart>> = around.collect();
        if let Some(first) = around.first().cloned() {
            around.resize(points.len(), first);
        }
        around
    }

    /// Whether no triangle of a closed body comes near the box of some points (m).
    fn is_free_between(&self, points: &[Vec3]) -> bool {
        let Some(first) = points.first() else { return false };
        let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
        let mut is_free = true;
        self.tree.near(0.5 * (low + high), 0.5 * (high - low).max(), |t| is_free &= self.body[t as usize] == OPEN);
        is_free
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
        RAYS.iter().find_map(|ray| {
            let far = end(point, *ray, self.uncut.reach);
            self.add_crossings(Vec::new(), [point, far], &key)
        })
    }

    /// Nonzero winding numbers around the first of two points (m), from those `around` the second one. `None` if the segment between them hits an edge.
    fn add_crossings<K: Copy + Ord>(
        &self,
        mut around: Vec<(K, i32)>,
        [point, far]: [Vec3; 2],
        key: impl Fn(u32) -> K,
    ) -> Option<Vec<(K, i32)>> {
        let mut hits = Vec::new();
        self.tree.along(point, far, |triangle| hits.push(triangle));
        for triangle in hits.into_iter().filter(|&triangle| self.body[triangle as usize] != OPEN) {
            let crossing = crossing(self.corners_of(triangle), point, far)?;
            let key = key(triangle);
            match around.iter_mut().find(|(known, _)| *known == key) {
                Some((_, winding)) => *winding += crossing,
                None => around.push((key, crossing)),
            }
        }
        around.retain(|(_, winding)| *winding != 0);
        around.sort_unstable();
        Some(around)
    }
}
