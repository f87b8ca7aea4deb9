//! Reflections: in planes normal to axes of the scene, exact to the last bit, or in a plane of any direction, to rounding.

use nalgebra::{Quaternion, UnitQuaternion};
use pliant_solver::Vec3;

/// Axes (x, y, z) along which a point is mirrored: those that are `true`.
pub type Axes = [bool; 3];

/// The vector with its components along `axes` negated.
pub fn mirrored(mut vector: Vec3, axes: Axes) -> Vec3 {
    (0..3).filter(|i| axes[*i]).for_each(|i| vector[i] = -vector[i]);
    vector
}

/// A reflection of vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reflection {
    /// Along these axes of the scene.
    Axes(Axes),
    /// In the plane with this unit normal.
    Plane(Vec3),
}

impl Reflection {
    /// The reflection in a plane with this normal, which is not zero. A normal along an axis gives the exact reflection along it.
    pub fn in_plane(normal: Vec3) -> Self {
        match (0..3).find(|i| (0..3).all(|k| k == *i || normal[k] == 0.0)) {
            Some(axis) => Self::Axes(std::array::from_fn(|i| i == axis)),
            None => Self::Plane(normal.normalize()),
        }
    }

    /// The mirror image of a vector.
    pub fn vector(&self, v: Vec3) -> Vec3 {
        match self {
            Self::Axes(axes) => mirrored(v, *axes),
            Self::Plane(normal) => v - 2.0 * normal.dot(&v) * normal,
        }
    }

    /// Rotation of the mirror image of an object with rotation R: `M R D`. M is this reflection and D the reflection of the object in its own frame
    /// ([`Reflection::in_own_frame`]), because M R alone is not a rotation. For reflections along axes D is M.
    pub fn rotation(&self, rotation: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        match self {
            // A rotation axis is a pseudovector.
            Self::Axes(axes) => {
                let turns = axes.iter().filter(|a| **a).count() % 2 == 1;
                let axis = mirrored(rotation.imag(), *axes);
                let axis = if turns { -axis } else { axis };
                UnitQuaternion::new_unchecked(Quaternion::from_parts(rotation.w, axis))
            }
            // Both reflections are half turns with the sign of -1, which cancels.
            Self::Plane(normal) => half_turn(*normal) * rotation * half_turn(Vec3::x()),
        }
    }

    /// A direction in the frame of an object, reflected to the frame of its mirror image.
    pub fn in_own_frame(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Axes(axes) => mirrored(direction, *axes),
            Self::Plane(_) => mirrored(direction, [true, false, false]),
        }
    }

    /// Description for messages and names of tools: `x and z`, or the normal of a plane.
    pub fn words(&self) -> String {
        match self {
            Self::Axes(axes) => {
                let names: Vec<&str> =
                    ["x", "y", "z"].into_iter().zip(axes).filter(|(_, set)| **set).map(|(n, _)| n).collect();
                names.join(" and ")
            }
            Self::Plane(normal) => {
                let [x, y, z] = [0, 1, 2].map(|i| format!("{:.3}", normal[i]));
                format!("a plane with the normal [{x} {y} {z}]")
            }
        }
    }
}

/// The rotation by half a turn about a unit vector.
fn half_turn(about: Vec3) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::from_parts(0.0, about))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirrored_rotation_does_to_mirrored_vectors_what_the_rotation_does() {
        let mut random = pliant_mesh::testing::Random(11);
        for _ in 0..50 {
            let reflections = [
                Reflection::Axes([true, false, false]),
                Reflection::Axes([true, false, true]),
                Reflection::Axes([true, true, true]),
                Reflection::in_plane(random.vector()),
            ];
            let rotation = UnitQuaternion::from_scaled_axis(2.0 * random.vector());
            for reflection in reflections {
                let v = random.vector();
                let image = reflection.rotation(rotation) * reflection.in_own_frame(v);
                assert!((image - reflection.vector(rotation * v)).norm() < 1e-14, "{reflection:?}");
            }
        }
    }

    #[test]
    fn a_plane_normal_to_an_axis_is_exact() {
        assert_eq!(Reflection::in_plane(Vec3::new(0.0, -3.0, 0.0)), Reflection::Axes([false, true, false]));
        let v = Vec3::new(0.1, 0.2, 0.3);
        assert_eq!(Reflection::in_plane(Vec3::new(0.0, 2.0, 0.0)).vector(v), Vec3::new(0.1, -0.2, 0.3));
    }
}
