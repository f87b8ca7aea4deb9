//! Mirror symmetry of strokes: a second hand does what the first one does, on the other side of a plane.

use nalgebra::UnitQuaternion;
use pliant_editor::HandPlace;
use pliant_solver::Vec3;

/// A plane across an axis of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorPlane {
    /// Axis the plane lies across: 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// m, where it crosses the axis
    pub offset: f64,
}

/// Share of the model's size by which its middle may be off the origin for its own plane of symmetry to be sought there.
const CENTRED: f64 = 0.1;

impl MirrorPlane {
    /// The plane of a model whose box has this middle and this longest edge (m): through the origin, where modelers put a plane of
    /// symmetry, or through the middle of a model that stands elsewhere.
    pub fn of_model(axis: usize, middle: Vec3, size: f64) -> Self {
        let is_centred = middle[axis].abs() <= CENTRED * size;
        Self { axis, offset: if is_centred { 0.0 } else { middle[axis] } }
    }

    /// The place (m) on the other side.
    pub fn point(&self, point: Vec3) -> Vec3 {
        let mut mirrored = point;
        mirrored[self.axis] = 2.0 * self.offset - point[self.axis];
        mirrored
    }

    /// The direction on the other side.
    pub fn direction(&self, direction: Vec3) -> Vec3 {
        let mut mirrored = direction;
        mirrored[self.axis] = -direction[self.axis];
        mirrored
    }

    /// The hand on the other side: its z axis, along which a blade lies, is mirrored; a hand itself has no mirror image.
    pub fn hand(&self, place: &HandPlace) -> HandPlace {
        let along = self.direction(place.rotation * Vec3::z());
        let half_turn = || UnitQuaternion::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI);
        let rotation = UnitQuaternion::rotation_between(&Vec3::z(), &along).unwrap_or_else(half_turn);
        HandPlace { position: self.point(place.position), rotation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hand_and_its_mirror_image_lie_on_both_sides_of_the_plane() {
        for axis in 0..3 {
            let plane = MirrorPlane { axis, offset: 0.02 };
            let rotation = UnitQuaternion::from_euler_angles(0.3, -1.1, 2.0);
            let place = HandPlace { position: Vec3::new(0.03, -0.04, 0.05), rotation };
            let mirrored = plane.hand(&place);
            let middle = 0.5 * (place.position + mirrored.position);
            assert!((middle[axis] - 0.02).abs() < 1e-15);
            let (own, other) = (place.rotation * Vec3::z(), mirrored.rotation * Vec3::z());
            assert!((plane.direction(own) - other).norm() < 1e-12);
            assert!((plane.hand(&mirrored).position - place.position).norm() < 1e-15);
        }
    }

    #[test]
    fn a_centred_model_is_mirrored_at_the_origin_and_another_at_its_middle() {
        let middle = Vec3::new(0.004, 0.3, 0.0);
        assert_eq!(MirrorPlane::of_model(0, middle, 0.1).offset, 0.0);
        assert_eq!(MirrorPlane::of_model(1, middle, 0.1).offset, 0.3);
    }
}
