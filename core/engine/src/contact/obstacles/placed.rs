//! An obstacle where it is in a step.

use crate::contact::Friction;
use crate::obstacle::{Nearest, ObstacleSurface, turn};
use nalgebra::UnitQuaternion;
use pliant_solver::Vec3;
use std::sync::Arc;

/// An obstacle at the beginning of a step or substep.
#[derive(Clone, Debug)]
pub struct PlacedObstacle {
    /// Surface, in axes of the obstacle.
    pub surface: Arc<ObstacleSurface>,
    /// Rotation from axes of the obstacle to those of the scene.
    pub rotation: UnitQuaternion<f64>,
    /// Position of its origin, m.
    pub position: Vec3,
    /// Velocity of its origin, m/s, constant over the step.
    pub velocity: Vec3,
    /// Angular velocity about its origin, rad/s, constant over the step.
    pub spin: Vec3,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
    /// Coefficients of friction.
    pub friction: Friction,
}

/// Where a point may go: not below the plane with this normal, `gap` below it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactPlane {
    /// Unit normal, out of the obstacle.
    pub normal: Vec3,
    /// Distance of the point from the plane at the beginning of the step, m; negative inside of the obstacle.
    pub gap: f64,
}

impl PlacedObstacle {
    /// Velocity of the point of it at `x` (m), m/s.
    pub(super) fn velocity_at(&self, x: Vec3) -> Vec3 {
        if self.spin == Vec3::zeros() { self.velocity } else { self.velocity + self.spin.cross(&(x - self.position)) }
    }

    /// Moves it by a time (s) that may be negative.
    pub(super) fn advance(&mut self, dt: f64) {
        self.position += dt * self.velocity;
        if self.spin != Vec3::zeros() {
            self.rotation = turn(dt * self.spin) * self.rotation;
        }
    }

    /// Distance of a point at `x` (m) from the surface once it has moved by `dt` (s), with the normal there.
    pub(super) fn nearest_after(&self, x: Vec3, dt: f64) -> Nearest {
        let x = x - dt * self.velocity;
        if self.spin == Vec3::zeros() {
            return self.nearest(x);
        }
        let turned = turn(dt * self.spin);
        let Nearest { distance, normal } = self.nearest(self.position + turned.inverse() * (x - self.position));
        Nearest { distance, normal: turned * normal }
    }

    /// Distance of a point of the scene (m) from the surface; the normal is in axes of the scene.
    pub fn nearest(&self, x: Vec3) -> Nearest {
        let Nearest { distance, normal } = self.surface.nearest(self.to_own(x - self.position));
        Nearest { distance, normal: self.rotation * normal }
    }

    /// The plane of contact of a point that moves from `x` (m) at `velocity` (m/s) in a step of `dt` (s): where its path first meets the surface, else
    /// at the closest point of the surface.
    pub(super) fn plane(&self, x: Vec3, velocity: Vec3, dt: f64) -> ContactPlane {
        let start = self.nearest(x);
        let way = dt * (velocity - self.velocity_at(x));
        let closest = ContactPlane { normal: start.normal, gap: start.distance };
        if start.distance <= 0.0 || start.distance > way.norm() {
            return closest;
        }
        let Some(hit) = self.surface.first_hit(self.to_own(x - self.position), self.to_own(way)) else {
            return closest;
        };
        let normal = self.rotation * hit.normal;
        ContactPlane { normal, gap: -hit.at * normal.dot(&way) }
    }

    fn to_own(&self, v: Vec3) -> Vec3 {
        self.rotation.inverse_transform_vector(&v)
    }
}
