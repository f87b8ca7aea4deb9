//! A box with sharp edges.

use super::{Shape, ShapeKind, ShapeParams};
use pliant_mesh::geometry::Vec3;
use std::sync::Arc;

/// A box about the centre with sides along the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Cuboid {
    /// Half of the length of each side, m.
    half: Vec3,
    corners: [Vec3; 8],
}

impl Cuboid {
    /// A box with sides of these lengths, m.
    pub fn new(size: Vec3) -> Self {
        let half = 0.5 * size;
        let corner = |k: usize| Vec3::from_fn(|i, _| if k >> i & 1 == 1 { half[i] } else { -half[i] });
        Self { half, corners: std::array::from_fn(corner) }
    }

    /// Signed distance of a point from each pair of faces, m.
    fn offset_from_faces(&self, p: Vec3) -> Vec3 {
        p.abs() - self.half
    }
}

impl Shape for Cuboid {
    fn distance(&self, p: Vec3) -> f64 {
        let q = self.offset_from_faces(p);
        let inside = q.max();
        if inside <= 0.0 { inside } else { q.sup(&Vec3::zeros()).norm() }
    }

    fn normal(&self, p: Vec3) -> Option<Vec3> {
        let q = self.offset_from_faces(p);
        let signs = p.map(|c| if c < 0.0 { -1.0 } else { 1.0 });
        if q.max() > 0.0 {
            return q.sup(&Vec3::zeros()).component_mul(&signs).try_normalize(0.0);
        }
        // Inside, the normal of the closest face; the first one of several.
        let mut normal = Vec3::zeros();
        normal[q.imax()] = signs[q.imax()];
        Some(normal)
    }

    fn support(&self, direction: Vec3) -> f64 {
        self.half.dot(&direction.abs())
    }

    fn bounds(&self) -> [Vec3; 2] {
        [-self.half, self.half]
    }

    fn sample_points(&self) -> &[Vec3] {
        &self.corners
    }

    fn feature_size(&self) -> f64 {
        self.half.min()
    }
}

/// The kind `box` in scene files.
pub(super) struct Kind;

impl ShapeKind for Kind {
    fn name(&self) -> &'static str {
        "box"
    }

    fn summary(&self) -> &'static str {
        "A box with sides of `size` along x, y and z of the hand."
    }

    fn keys(&self) -> &'static [&'static str] {
        &["size"]
    }

    fn build(&self, params: &ShapeParams) -> Arc<dyn Shape> {
        Arc::new(Cuboid::new(params.size.unwrap_or_default().into()))
    }
}
