//! A capsule: a cylinder with round ends.

use super::{Shape, ShapeKind, ShapeParams};
use pliant_mesh::geometry::Vec3;
use std::sync::Arc;

/// All points within a radius of a segment along z, whose midpoint is the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Radius of the round ends and of the cylinder between them, m.
    radius: f64,
    /// Points of [`Shape::sample_points`]: the ends of the segment, m.
    ends: [Vec3; 2],
}

impl Capsule {
    /// A capsule around a segment of this length, with a total length of `length + 2 radius`; both in m.
    pub fn new(radius: f64, length: f64) -> Self {
        Self { radius, ends: [-0.5, 0.5].map(|share| Vec3::new(0.0, 0.0, share * length)) }
    }

    /// Vector from the closest point of the segment to `p`, m.
    fn offset_from_axis(&self, p: Vec3) -> Vec3 {
        let [low, high] = self.ends.map(|end| end.z);
        Vec3::new(p.x, p.y, p.z - p.z.clamp(low, high))
    }
}

impl Shape for Capsule {
    fn distance(&self, p: Vec3) -> f64 {
        self.offset_from_axis(p).norm() - self.radius
    }

    fn normal(&self, p: Vec3) -> Option<Vec3> {
        self.offset_from_axis(p).try_normalize(1e-12)
    }

    fn support(&self, direction: Vec3) -> f64 {
        self.radius + self.ends[1].z * direction.z.abs()
    }

    fn bounds(&self) -> [Vec3; 2] {
        let high = Vec3::new(self.radius, self.radius, self.radius + self.ends[1].z);
        [-high, high]
    }

    fn sample_points(&self) -> &[Vec3] {
        &self.ends
    }

    fn feature_size(&self) -> f64 {
        self.radius
    }

    fn bounding_radius(&self) -> f64 {
        self.radius + self.ends[1].z
    }
}

/// The kind `capsule` in scene files.
pub(super) struct Kind;

impl ShapeKind for Kind {
    fn name(&self) -> &'static str {
        "capsule"
    }

    fn summary(&self) -> &'static str {
        "All points within `radius` of a segment of `length` along z of the hand."
    }

    fn keys(&self) -> &'static [&'static str] {
        &["radius", "length"]
    }

    fn build(&self, params: &ShapeParams) -> Arc<dyn Shape> {
        Arc::new(Capsule::new(params.radius.unwrap_or_default(), params.length.unwrap_or_default()))
    }
}
