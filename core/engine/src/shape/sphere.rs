//! A sphere.

use super::{Shape, ShapeKind, ShapeParams};
use pliant_mesh::geometry::{Closest, Vec3, closest_point};
use std::sync::Arc;

/// Distance from the centre below which the normal is undefined, m.
const CENTRE: f64 = 1e-12;

/// A sphere about the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Distance of its surface from the centre, m.
    pub radius: f64,
}

impl Shape for Sphere {
    fn distance(&self, p: Vec3) -> f64 {
        p.norm() - self.radius
    }

    fn normal(&self, p: Vec3) -> Option<Vec3> {
        let distance = p.norm();
        (distance > CENTRE).then(|| p / distance)
    }

    fn support(&self, _: Vec3) -> f64 {
        self.radius
    }

    fn bounds(&self) -> [Vec3; 2] {
        [Vec3::repeat(-self.radius), Vec3::repeat(self.radius)]
    }

    fn sample_points(&self) -> &[Vec3] {
        const CENTRE: [Vec3; 1] = [Vec3::new(0.0, 0.0, 0.0)];
        &CENTRE
    }

    fn feature_size(&self) -> f64 {
        self.radius
    }

    fn bounding_radius(&self) -> f64 {
        self.radius
    }

    fn is_round(&self) -> bool {
        true
    }

    fn contains(&self, p: Vec3, margin: f64) -> bool {
        p.norm() <= self.radius + margin
    }

    fn first_hit(&self, start: Vec3, way: Vec3, margin: f64) -> Option<f64> {
        // Solves |start + s way| = reach for s.
        let reach = self.radius + margin;
        let (a, b, c) = (way.norm_squared(), start.dot(&way), start.norm_squared() - reach * reach);
        let root = b * b - a * c;
        let s = if c <= 0.0 { 0.0 } else { (-b - root.max(0.0).sqrt()) / a };
        (b < 0.0 && root >= 0.0 && s <= 1.0).then_some(s)
    }

    fn closest_on_triangle(&self, corners: [Vec3; 3]) -> Closest {
        closest_point(Vec3::zeros(), corners)
    }
}

/// The kind `sphere` in scene files.
pub(super) struct Kind;

impl ShapeKind for Kind {
    fn name(&self) -> &'static str {
        "sphere"
    }

    fn summary(&self) -> &'static str {
        "A ball of `radius` around the hand."
    }

    fn keys(&self) -> &'static [&'static str] {
        &["radius"]
    }

    fn build(&self, params: &ShapeParams) -> Arc<dyn Shape> {
        Arc::new(Sphere { radius: params.radius.unwrap_or_default() })
    }
}
