//! The place of a cut surface that is nearest to a point.

use super::mesh::CutMesh;
use pliant_mesh::geometry::{Vec3, closest_point};

/// A point of a cut surface.
pub struct CapPoint {
    /// Position, m.
    pub position: Vec3,
    /// Unit normal of the triangle that it is in, by the order of its corners.
    pub normal: Vec3,
    /// Whether it is on the border of the cut surface with the original surface, beyond which is nothing to cut.
    pub is_at_skin: bool,
}

/// Distance up to which a point is on another triangle too, as a share of the reach of the search.
const SAME_PLACE: f64 = 1e-6;

impl CutMesh {
    /// The place of a cut surface that is nearest to a point (m), within `reach` (m) of it.
    pub fn nearest_cap(&self, point: Vec3, reach: f64) -> Option<CapPoint> {
        let mut nearest: Option<(f64, Vec3, u32)> = None;
        self.tree.near(point, reach, |triangle| {
            if self.is_cap(triangle) {
                let closest = closest_point(point, self.corners_of(triangle)).point;
                let distance = (closest - point).norm();
                if distance <= nearest.map_or(reach, |(least, ..)| least) {
                    nearest = Some((distance, closest, triangle));
                }
            }
        });
        let (_, position, triangle) = nearest?;
        let normal = self.cross(triangle).try_normalize(0.0)?;
        let (mut is_at_skin, near) = (false, SAME_PLACE * reach);
        self.tree.near(position, near, |other| {
            is_at_skin |= !self.is_cap(other)
                && (closest_point(position, self.corners_of(other)).point - position).norm() <= near;
        });
        Some(CapPoint { position, normal, is_at_skin })
    }
}
