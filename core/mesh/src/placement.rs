//! Placement of a model in the scene: transform from file units to metres and back.

use std::iter::zip;

use nalgebra::UnitQuaternion;

use super::{Bounds, MeshError};
use crate::geometry::Vec3;

/// A similarity transform: scaling about the origin, then rotation, then translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Metres per file unit, above 0.
    pub scale: f64,
    /// Rotation about the origin.
    pub rotation: UnitQuaternion<f64>,
    /// Translation after rotation and scaling, m.
    pub translation: Vec3,
}

impl Default for Placement {
    /// One metre per file unit, without rotation and translation.
    fn default() -> Self {
        Self { scale: 1.0, rotation: UnitQuaternion::identity(), translation: Vec3::zeros() }
    }
}

impl Placement {
    /// A placement without rotation that scales the longest edge of `bounds` (file units) to `size` (m) and moves its centre to the origin.
    ///
    /// # Errors
    /// [`MeshError::NoSize`] if the box is a point; [`MeshError::Parameter`] if `size` is not finite and above 0.
    pub fn fit(bounds: &Bounds, size: f64) -> Result<Self, MeshError> {
        if !(size.is_finite() && size > 0.0) {
            let allowed = "a finite length above 0 m";
            return Err(MeshError::Parameter { parameter: "size", found: size.to_string(), allowed });
        }
        let longest = bounds.longest_edge();
        let scale = size / longest;
        if !(longest > 0.0 && scale.is_normal()) {
            return Err(MeshError::NoSize { found: longest });
        }
        Ok(Self { scale, translation: -scale * bounds.centre(), ..Self::default() })
    }

    /// Transforms a point from file units to metres.
    pub fn apply(&self, point: Vec3) -> Vec3 {
        self.rotation * (self.scale * point) + self.translation
    }

    /// Transforms a point from metres to file units.
    pub fn apply_inverse(&self, point: Vec3) -> Vec3 {
        self.rotation.inverse() * (point - self.translation) / self.scale
    }

    /// Transforms edited points to file units, for writing (n x 3).
    ///
    /// The transform rounds, so a point of `edited` (m) that equals its `placed` one (m) gets the exact bits of `original` (file units). The result has the length
    /// of the shortest of the three.
    pub fn bring_back(&self, original: &[Vec3], placed: &[Vec3], edited: &[Vec3]) -> Vec<Vec3> {
        zip(original, zip(placed, edited))
            .map(|(original, (placed, edited))| if placed == edited { *original } else { self.apply_inverse(*edited) })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        let placement = Placement {
            scale: 0.001,
            rotation: UnitQuaternion::from_euler_angles(0.3, -1.0, 2.0),
            translation: Vec3::new(5.0, 6.0, 7.0),
        };
        let point = Vec3::new(10.0, -20.0, 30.0);
        let back = placement.apply_inverse(placement.apply(point));
        assert!((point - back).norm() < 1e-10, "{back:?}");
        let placed = placement.apply(Vec3::zeros());
        assert_eq!(placed, Vec3::new(5.0, 6.0, 7.0));
    }

    #[test]
    fn untouched_points_come_back_bit_for_bit() {
        let placement = Placement { scale: 0.1, translation: Vec3::new(0.7, 0.0, 0.0), ..Placement::default() };
        let original = [Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.1, 1.2, 1.3)];
        let placed = original.map(|point| placement.apply(point));
        let edited = [placed[0], Vec3::zeros()];
        let back = placement.bring_back(&original, &placed, &edited);
        assert_eq!(back[0], original[0]);
        assert!((back[1][0] + 7.0).abs() < 1e-12);
    }

    #[test]
    fn fits_the_longest_edge() {
        let bounds = Bounds { min: Vec3::x(), max: Vec3::new(3.0, 1.0, 1.0) };
        let placement = Placement::fit(&bounds, 0.1).unwrap();
        assert_eq!(placement.apply(Vec3::new(1.0, 0.5, 0.5)), Vec3::new(-0.05, 0.0, 0.0));
        assert!(matches!(Placement::fit(&bounds, 0.0), Err(MeshError::Parameter { .. })));
        let point = Bounds { min: Vec3::repeat(1.0), max: Vec3::repeat(1.0) };
        assert!(matches!(Placement::fit(&point, 0.1), Err(MeshError::NoSize { .. })));
    }
}
