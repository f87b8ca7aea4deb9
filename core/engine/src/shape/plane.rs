//! A plane: a half-space.

use super::{Shape, ShapeKind, ShapeParams};
use pliant_mesh::geometry::Vec3;
use std::sync::Arc;

/// Length scale of a plane, m, which has no size of its own: that of a fingertip.
const LENGTH_SCALE: f64 = 0.01;

/// The half-space `z <= 0`; its outward normal is z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane;

impl Shape for Plane {
    fn distance(&self, p: Vec3) -> f64 {
        p.z
    }

    fn normal(&self, _: Vec3) -> Option<Vec3> {
        Some(Vec3::z())
    }

    fn support(&self, direction: Vec3) -> f64 {
        // The support is finite for the normal alone; the tolerance allows for its rounding.
        if direction.z > 1.0 - 1e-12 { 0.0 } else { f64::INFINITY }
    }

    fn bounds(&self) -> [Vec3; 2] {
        [Vec3::repeat(f64::NEG_INFINITY), Vec3::new(f64::INFINITY, f64::INFINITY, 0.0)]
    }

    fn sample_points(&self) -> &[Vec3] {
        &[]
    }

    fn feature_size(&self) -> f64 {
        f64::INFINITY
    }

    fn length_scale(&self) -> f64 {
        LENGTH_SCALE
    }

    fn bounding_radius(&self) -> f64 {
        f64::INFINITY
    }
}

/// The kind `plane` in scene files.
pub(super) struct Kind;

impl ShapeKind for Kind {
    fn name(&self) -> &'static str {
        "plane"
    }

    fn summary(&self) -> &'static str {
        "The face of a plate without end, through the hand, with z of the hand out of it."
    }

    fn keys(&self) -> &'static [&'static str] {
        &[]
    }

    fn build(&self, _: &ShapeParams) -> Arc<dyn Shape> {
        Arc::new(Plane)
    }
}
