//! Where a model stands in the scene: file units to metres and back.

use std::iter::zip;

use nalgebra::UnitQuaternion;

use super::{Bounds, MeshError};
use crate::geometry::Vec3;

/// A similarity transform: scaled about the origin, then turned, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Metres per file unit, above 0.
    pub scale: f64,
    /// Turn about the origin.
    pub rotation: UnitQuaternion<f64>,
    /// Move after scale and turn, m.
    pub translation: Vec3,
}

impl Default for Placement {
    /// One file unit is a metre, nothing turned or moved.
    fn default() -> Self {
        Self { scale: 1.0, rotation: UnitQuaternion::identity(), translation: Vec3::zeros() }
    }
}

impl Placement {
    /// Unturned, the longest edge of `bounds` (file units) becomes `size` (m) and its centre the origin.
    ///
    /// # Errors
    /// [`MeshError::NoSize`] when the box is a point; [`MeshError::Parameter`] when `size` is not finite and above 0.
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

    /// A point in file units to metres.
    pub fn apply(&self, point: Vec3) -> Vec3 {
        self.rotation * (self.scale * point) + self.translation
    }

    /// A point in metres to file units.
    pub fn apply_inverse(&self, point: Vec3) -> Vec3 {
        self.rotation.inverse() * (point - self.translation) / self.scale
    }

    /// Edited points back in file units, for writing (n x 3).
    ///
    /// Going there and back rounds, so a point of `edited` (m) that still equals its `placed` one (m) takes the very
    /// bits of `original` (file units). Goes as far as the shortest of the three.
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
