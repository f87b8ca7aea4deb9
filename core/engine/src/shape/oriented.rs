//! A shape with a rotation.

use super::{Shape, Sphere};
use nalgebra::UnitQuaternion;
use pliant_mesh::geometry::{Closest, Vec3};
use std::sync::Arc;

/// A shape with a rotation. Points are relative to its centre, in axes of the scene, m.
#[derive(Clone, Debug)]
pub struct OrientedShape {
    shape: Arc<dyn Shape>,
    /// Rotation from axes of the shape to those of the scene.
    rotation: UnitQuaternion<f64>,
}

impl OrientedShape {
    /// A shape whose axes are those of the scene.
    pub fn new(shape: Arc<dyn Shape>) -> Self {
        Self { shape, rotation: UnitQuaternion::identity() }
    }

    /// A sphere of `radius`, m.
    pub fn sphere(radius: f64) -> Self {
        Self::new(Arc::new(Sphere { radius }))
    }

    /// The shape itself, in its own axes.
    pub fn shape(&self) -> &dyn Shape {
        &*self.shape
    }

    /// Rotation from axes of the shape to those of the scene; the identity for a sphere.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        self.rotation
    }

    /// Sets the rotation; ignored for a sphere.
    pub fn set_rotation(&mut self, rotation: UnitQuaternion<f64>) {
        if !self.shape.is_round() {
            self.rotation = rotation;
        }
    }

    fn to_shape(&self, v: Vec3) -> Vec3 {
        if self.shape.is_round() { v } else { self.rotation.inverse_transform_vector(&v) }
    }

    fn to_scene(&self, v: Vec3) -> Vec3 {
        if self.shape.is_round() { v } else { self.rotation * v }
    }

    /// [`Shape::distance`] of a point given relative to the centre in axes of the scene, m.
    pub fn distance(&self, p: Vec3) -> f64 {
        self.shape.distance(self.to_shape(p))
    }

    /// [`Shape::normal`], a unit vector.
    pub fn normal(&self, p: Vec3) -> Option<Vec3> {
        self.shape.normal(self.to_shape(p)).map(|n| self.to_scene(n))
    }

    /// [`Shape::support`] along a unit vector, m.
    pub fn support(&self, direction: Vec3) -> f64 {
        self.shape.support(self.to_shape(direction))
    }

    /// [`Shape::contains`] for a point given relative to the centre in axes of the scene, m.
    pub fn contains(&self, p: Vec3, margin: f64) -> bool {
        self.shape.contains(self.to_shape(p), margin)
    }

    /// [`Shape::first_hit`] for a start and a way given in axes of the scene, m.
    pub fn first_hit(&self, start: Vec3, way: Vec3, margin: f64) -> Option<f64> {
        self.shape.first_hit(self.to_shape(start), self.to_shape(way), margin)
    }

    /// The point of a triangle closest to the shape with its centre at `centre`; both in axes of the scene, m.
    pub fn closest_on_triangle(&self, centre: Vec3, corners: [Vec3; 3]) -> Closest {
        if self.shape.is_round() {
            return pliant_mesh::geometry::closest_point(centre, corners);
        }
        let found = self.shape.closest_on_triangle(corners.map(|c| self.to_shape(c - centre)));
        Closest { point: (0..3).map(|i| found.bary[i] * corners[i]).sum(), bary: found.bary }
    }

    /// Vector from a point, relative to the centre, towards the shape, not normalised: a surface whose normal has a positive component along it faces
    /// the shape.
    pub fn towards(&self, p: Vec3) -> Vec3 {
        if self.shape.is_round() { -p } else { -self.normal(p).unwrap_or(p) }
    }

    /// Additional radius of the simulated region around a contact, m: the bounding radius of a shape that is not a sphere; 0 for a sphere and for an
    /// infinite shape, so that a local region stays local.
    pub fn extra_region_radius(&self) -> f64 {
        let radius = self.shape.bounding_radius();
        if self.shape.is_round() || radius.is_infinite() { 0.0 } else { radius }
    }
}
