//! The surface of an obstacle: a convex shape or a mesh, with its signed distance and the first hit of a path.

use super::mesh::MeshSurface;
use crate::shape::Shape;
use pliant_solver::Vec3;
use std::sync::Arc;

/// Surface of an obstacle, in axes of its own.
#[derive(Clone, Debug)]
pub enum ObstacleSurface {
    /// A convex shape, of those that tools have, and the distance from it at which bodies meet it, m.
    Shape(Arc<dyn Shape>, f64),
    /// A triangle mesh.
    Mesh(Box<MeshSurface>),
}

/// Distance of a point from a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Signed distance, m; negative inside.
    pub distance: f64,
    /// Its gradient: unit outward normal.
    pub normal: Vec3,
}

/// Where a path enters a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Parameter of the path, 0 to 1.
    pub at: f64,
    /// Unit outward normal.
    pub normal: Vec3,
}

/// Largest number of steps along a path to a mesh; then the path counts as missing it.
const MAX_TRACE_STEPS: usize = 64;
/// Distance from a mesh that counts as a hit, in lengths of the path.
const TRACE_TOLERANCE: f64 = 1e-6;

impl ObstacleSurface {
    /// Distance of a point (m) from the surface.
    pub fn nearest(&self, p: Vec3) -> Nearest {
        match self {
            Self::Shape(shape, thickness) => {
                Nearest { distance: shape.distance(p) - thickness, normal: shape.normal(p).unwrap_or_else(Vec3::z) }
            }
            Self::Mesh(mesh) => mesh.nearest(p),
        }
    }

    /// Where the path from `start` to `start + way` (m) enters the surface from outside; `None` if it does not.
    pub fn first_hit(&self, start: Vec3, way: Vec3) -> Option<SurfaceHit> {
        match self {
            Self::Shape(shape, thickness) => {
                let at = shape.first_hit(start, way, *thickness)?;
                Some(SurfaceHit { at, normal: shape.normal(start + at * way).unwrap_or_else(Vec3::z) })
            }
            Self::Mesh(mesh) => trace(mesh, start, way),
        }
    }

    /// Axis-aligned bounding box: smallest and largest coordinates, m; may be infinite.
    pub fn bounds(&self) -> [Vec3; 2] {
        match self {
            Self::Shape(shape, thickness) => {
                let ([low, high], margin) = (shape.bounds(), Vec3::repeat(*thickness));
                [low - margin, high + margin]
            }
            Self::Mesh(mesh) => mesh.bounds(),
        }
    }

    /// Smallest feature that points of a body must be dense enough for, m; infinite for a plane. Of a mesh it is not known, and the largest extent.
    pub fn feature_size(&self) -> f64 {
        match self {
            Self::Shape(shape, thickness) => shape.feature_size() + thickness,
            Self::Mesh(mesh) => {
                let [low, high] = mesh.bounds();
                (high - low).max()
            }
        }
    }
}

/// Sphere tracing (Hart 1996): each step is as long as the distance allows, so nothing is passed.
fn trace(mesh: &MeshSurface, start: Vec3, way: Vec3) -> Option<SurfaceHit> {
    let length = way.norm();
    let mut at = 0.0;
    for _ in 0..MAX_TRACE_STEPS {
        let Nearest { distance, normal } = mesh.nearest(start + at * way);
        if distance <= TRACE_TOLERANCE * length {
            if normal.dot(&way) < 0.0 {
                return Some(SurfaceHit { at, normal });
            }
            at += TRACE_TOLERANCE; // it leaves the surface, or glides along it
        }
        at += distance.max(0.0) / length;
        if at.is_nan() || at > 1.0 {
            return None;
        }
    }
    None
}
