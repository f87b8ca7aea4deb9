//! Rotations by rotation vectors, with the same bits on every platform.

use nalgebra::{Quaternion, UnitQuaternion};
use pliant_solver::Vec3;

/// The rotation by a rotation vector: about its direction by its length, rad.
pub fn turn(vector: Vec3) -> UnitQuaternion<f64> {
    let angle = vector.norm();
    if angle == 0.0 {
        return UnitQuaternion::identity();
    }
    let (sin, cos) = libm::sincos(0.5 * angle);
    UnitQuaternion::new_normalize(Quaternion::from_parts(cos, sin / angle * vector))
}

/// The rotation vector of a rotation, rad, of at most half a turn.
pub fn rotation_vector(rotation: &UnitQuaternion<f64>) -> Vec3 {
    let (real, imaginary) = (rotation.w, rotation.imag());
    let sin = imaginary.norm();
    if sin == 0.0 {
        return Vec3::zeros();
    }
    let angle = 2.0 * libm::atan2(sin, real.abs());
    real.signum() * angle / sin * imaginary
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::testing::Random;

    #[test]
    fn a_rotation_vector_and_its_rotation_are_inverse() {
        let mut random = Random(3);
        for _ in 0..100 {
            let vector = 3.1 * random.unit() * random.direction();
            let rotation = turn(vector);
            let axis = vector.normalize();
            assert!((rotation * axis - axis).norm() < 1e-14 && (rotation.angle() - vector.norm()).abs() < 1e-7);
            assert!((rotation_vector(&rotation) - vector).norm() < 1e-12, "{vector:?}");
            let far = turn(vector + 2.0 * std::f64::consts::PI * axis);
            assert!((rotation_vector(&far) - vector).norm() < 1e-9, "a turn more is the same: {vector:?}");
        }
        assert_eq!(rotation_vector(&turn(Vec3::zeros())), Vec3::zeros());
    }
}
