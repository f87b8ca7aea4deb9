//! Obstacles: rigid things that bodies meet and that feel nothing, as a floor, a table or another mesh.
//!
//! An obstacle has a surface with a signed distance, in axes of its own; it stands still or moves and turns along paths. Contact with it is in
//! `contact/obstacles`.

mod mesh;
mod surface;
mod turning;

pub use mesh::{MeshSurface, MeshSurfaceError};
pub use surface::{Nearest, ObstacleSurface, SurfaceHit};
pub(crate) use turning::{rotation_vector, turn};

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
    /// Rotation from axes of the obstacle to those of the scene, at the end of the last step.
    pub rotation: UnitQuaternion<f64>,
    /// Rotation from axes of the obstacle to those of the scene, without the path of its rotation.
    pub initial_rotation: UnitQuaternion<f64>,
    /// Position of its origin without the path, m.
    pub origin: Vec3,
    /// Times (s, ascending) and displacements from the origin (m); linear between, constant outside. Empty where it stands still.
    pub path: Vec<(f64, Vec3)>,
    /// Times (s, ascending) and rotation vectors (rad) by which it is turned about its origin; linear between, constant outside. Empty where it does not turn.
    pub turns: Vec<(f64, Vec3)>,
    /// Coefficients of friction between it and bodies.
    pub friction: Friction,
    /// Coefficient of restitution, 0 to 1: of the speed at which a point meets it, what they part with.
    pub restitution: f64,
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

    /// Rotation at a time (s).
    pub fn rotation_at(&self, time: f64) -> UnitQuaternion<f64> {
        if self.turns.is_empty() {
            return self.initial_rotation;
        }
        turn(displacement_along(&self.turns, time)) * self.initial_rotation
    }

    /// Mean angular velocity over a step, rad/s.
    pub fn spin(&self, time: StepTime) -> Vec3 {
        if is_changing(&self.turns) {
            rotation_vector(&(self.rotation_at(time.end()) * self.rotation_at(time.start).inverse())) / time.dt
        } else {
            Vec3::zeros()
        }
    }

    /// Upper bound of the mean speed over a step of its points at the places `x` (m), m/s.
    pub fn fastest(&self, x: &[Vec3], time: StepTime) -> f64 {
        let (speed, spin, centre) = (self.velocity(time).norm(), self.spin(time).norm(), self.position_at(time.start));
        if spin == 0.0 {
            return speed;
        }
        speed + spin * x.iter().fold(0.0, |far: f64, x| far.max((x - centre).norm()))
    }

    /// Mean velocity of its origin over a step, m/s.
    pub fn velocity(&self, time: StepTime) -> Vec3 {
        if is_changing(&self.path) {
            (self.position_at(time.end()) - self.position_at(time.start)) / time.dt
        } else {
            Vec3::zeros()
        }
    }

    /// Whether it moves at any time.
    pub fn moves(&self) -> bool {
        is_changing(&self.path) || is_changing(&self.turns)
    }

    /// Signed distance of a point of the scene (m) from the obstacle at its last position, m; negative inside.
    pub fn distance(&self, x: Vec3) -> f64 {
        self.surface.nearest(self.rotation.inverse_transform_vector(&(x - self.position))).distance
    }

    /// Axis-aligned box of the obstacle with its origin at `position` (m) and this rotation, in the scene: smallest and largest coordinates, m; may be infinite.
    pub fn bounds_at(&self, position: Vec3, rotation: UnitQuaternion<f64>) -> [Vec3; 2] {
        let [low, high] = self.surface.bounds();
        if !(low.iter().chain(high.iter()).all(|c| c.is_finite())) {
            return [Vec3::repeat(f64::NEG_INFINITY), Vec3::repeat(f64::INFINITY)];
        }
        let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
        let middle = position + rotation * centre;
        let turned = rotation.to_rotation_matrix().matrix().abs() * half;
        [middle - turned, middle + turned]
    }
}

/// Whether the values of a path differ.
fn is_changing(path: &[(f64, Vec3)]) -> bool {
    path.iter().any(|(_, value)| *value != path[0].1)
}
