//! Obstacles: rigid things that bodies meet and that feel nothing, as a floor, a table or another mesh.
//!
//! An obstacle has a surface with a signed distance, in axes of its own; it stands still or moves along a path. Contact with it is in
//! `contact/obstacles`.

mod mesh;
mod surface;

pub use mesh::{MeshSurface, MeshSurfaceError};
pub use surface::{Nearest, ObstacleSurface, SurfaceHit};

use crate::body::displacement_along;
use crate::contact::Friction;
use nalgebra::UnitQuaternion;
use pliant_solver::{StepTime, Vec3};
use std::sync::Arc;

/// An obstacle of a scene.
#[derive(Clone, Debug)]
pub struct Obstacle {
    /// Name in the scene.
    pub name: String,
    /// Name of its shape, or `mesh`.
    pub kind: String,
    /// Surface, in axes of the obstacle.
    pub surface: Arc<ObstacleSurface>,
    /// Rotation from axes of the obstacle to those of the scene.
    pub rotation: UnitQuaternion<f64>,
    /// Position of its origin without the path, m.
    pub origin: Vec3,
    /// Times (s, ascending) and displacements from the origin (m); linear between, constant outside. Empty where it stands still.
    pub path: Vec<(f64, Vec3)>,
    /// Coefficients of friction between it and bodies.
    pub friction: Friction,
    /// Position of its origin at the end of the last step, m.
    pub position: Vec3,
    /// Force of all bodies on it in the last step, N.
    pub force: Vec3,
    /// Energy that friction with it dissipated in the last step, J.
    pub friction_work: f64,
}

impl Obstacle {
    /// Position of its origin at a time (s), m.
    pub fn position_at(&self, time: f64) -> Vec3 {
        self.origin + displacement_along(&self.path, time)
    }

    /// Mean velocity over a step, m/s.
    pub fn velocity(&self, time: StepTime) -> Vec3 {
        if self.moves() {
            (self.position_at(time.end()) - self.position_at(time.start)) / time.dt
        } else {
            Vec3::zeros()
        }
    }

    /// Whether it moves at any time.
    pub fn moves(&self) -> bool {
        self.path.iter().any(|(_, d)| *d != self.path[0].1)
    }

    /// Signed distance of a point of the scene (m) from the obstacle at its last position, m; negative inside.
    pub fn distance(&self, x: Vec3) -> f64 {
        self.surface.nearest(self.rotation.inverse_transform_vector(&(x - self.position))).distance
    }

    /// Axis-aligned box of the obstacle with its origin at `position` (m), in the scene: smallest and largest coordinates, m; may be infinite.
    pub fn bounds_at(&self, position: Vec3) -> [Vec3; 2] {
        let [low, high] = self.surface.bounds();
        if !(low.iter().chain(high.iter()).all(|c| c.is_finite())) {
            return [Vec3::repeat(f64::NEG_INFINITY), Vec3::repeat(f64::INFINITY)];
        }
        let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
        let middle = position + self.rotation * centre;
        let turned = self.rotation.to_rotation_matrix().matrix().abs() * half;
        [middle - turned, middle + turned]
    }
}
