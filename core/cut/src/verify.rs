//! Verification of the triangles an advance has changed.

use super::error::{Refusal, Refused};
use super::mesh::CutMesh;
use super::record::{NONE, OPEN};
use pliant_mesh::geometry::Vec3;

impl CutMesh {
    /// Verifies the triangles that the open step has changed or added.
    pub(super) fn verify(&self) -> Result<(), Refused> {
        let (changed, first) = self.changed();
        let broken = |entity, value: f64| Refused { reason: Refusal::Invalid, entity, value };
        let mut used = vec![false; self.surface.points.len() - self.first_new_vertex() as usize];
        for triangle in changed.iter().copied().chain(first as u32..self.surface.triangles.len() as u32) {
            let corners = self.surface.triangles[triangle as usize];
            if corners.contains(&NONE)
                || corners[0] == corners[1]
                || corners[1] == corners[2]
                || corners[2] == corners[0]
            {
                return Err(broken("corners of triangle", f64::from(triangle)));
            }
            for vertex in corners {
                if let Some(new) = vertex.checked_sub(self.first_new_vertex()) {
                    used[new as usize] = true;
                }
            }
            let cross = self.cross(triangle).norm();
            if cross.is_nan() || cross <= 0.0 {
                return Err(Refused { reason: Refusal::Sliver, entity: "triangle", value: 0.0 });
            }
            for half in 3 * triangle..3 * triangle + 3 {
                self.verify_edge(half).ok_or(broken("edge of triangle", f64::from(triangle)))?;
            }
        }
        if let Some(vertex) = used.iter().position(|used| !used) {
            return Err(broken("vertex without triangle", f64::from(self.first_new_vertex()) + vertex as f64));
        }
        self.verify_volume(&changed, first)
    }

    fn verify_edge(&self, half: u32) -> Option<()> {
        let ends = [self.tail(half), self.head(half)];
        let mut count = 0;
        for other in self.around(half) {
            let there = [self.tail(other), self.head(other)];
            let body = self.body[other as usize / 3];
            let sound = there == ends || there == [ends[1], ends[0]];
            let opposite = body == OPEN || other == half || there != ends;
            if !sound || !opposite || body != self.body[half as usize / 3] {
                return None;
            }
            count += 1;
        }
        let closed = self.around(half).last().is_some_and(|last| self.link_of(last) == half);
        (closed && (self.body[half as usize / 3] == OPEN || count == 2)).then_some(())
    }

    /// Verifies that the volume between the changed triangles and a fixed point is the same as before.
    fn verify_volume(&self, changed: &[u32], first: usize) -> Result<(), Refused> {
        let Some(&some) = changed.first() else { return Ok(()) };
        let origin = self.point(self.surface.triangles[some as usize][0]);
        let cone = |corners: [u32; 3]| {
            let [a, b, c] = corners.map(|vertex| self.point(vertex) - origin);
            let value = a.dot(&b.cross(&c)) / 6.0;
            Vec3::new(value, value.abs(), 0.5 * (b - a).cross(&(c - a)).norm())
        };
        let now = changed.iter().copied().chain(first as u32..self.surface.triangles.len() as u32);
        let mut sums = [Vec3::zeros(); 2];
        for triangle in now {
            let mut cone = cone(self.surface.triangles[triangle as usize]);
            if self.is_cap(triangle) {
                cone.z = 0.0;
            }
            sums[1] += cone;
        }
        for (triangle, record) in self.previous_triangles() {
            let mut cone = cone(record.corners);
            if self.is_cap(triangle) {
                cone.z = 0.0;
            }
            sums[0] += cone;
        }
        let [before, after] = sums;
        let flat = before.z.max(after.z); // the volume of a flat mesh is rounding error
        if (before.x - after.x).abs() > 1e-11 * before.y.max(after.y) + 1e-14 * flat * self.uncut.reach {
            return Err(Refused { reason: Refusal::Invalid, entity: "volume", value: after.x - before.x });
        }
        if (before.z - after.z).abs() > 1e-12 * before.z + 1e-300 {
            return Err(Refused { reason: Refusal::Invalid, entity: "area", value: after.z - before.z });
        }
        Ok(())
    }
}
