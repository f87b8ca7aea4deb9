//! A plane: the face of a plate without end.

use super::{Shape, ShapeKind, ShapeParams};
use pliant_mesh::geometry::Vec3;
use std::sync::Arc;

/// Moves of a plane are resolved by this length, m, for it has no size of its own: half of it is a move of a fingertip.
const LENGTH_SCALE: f64 = 0.01;

/// The half-space `z <= 0`: z points out of the face.
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
        // Of unit vectors the normal alone has a bound; rounding may have turned it.
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

/// `plane` in scenes.
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
