//! Types of vectors and matrices, in space and in the sheet.

use pliant_plugin_api::lanes::Real;
pub(crate) use pliant_plugin_api::lanes::Vec3;

/// A vector in the sheet: components along warp and weft.
pub(crate) type Vec2<T = f64> = [T; 2];

/// A 2 x 2 matrix: `m[row][column]`.
pub(crate) type Mat2<T = f64> = [[T; 2]; 2];
/// A 3 x 3 matrix: `m[row][column]`.
pub(crate) type Mat3<T = f64> = [[T; 3]; 3];

/// A symmetric 2 x 2 tensor in the sheet as (11, 22, 12); of a strain, the last component is gamma = 2 e12 (Voigt's notation).
pub(crate) type Voigt<T = f64> = [T; 3];

/// All components times a number.
#[inline(always)]
pub(crate) fn scale<T: Real>(a: Voigt<T>, factor: f64) -> Voigt<T> {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

/// Sum of the products of the components. Of a stress and a strain: twice the energy density.
#[inline(always)]
pub(crate) fn contract<T: Real>(a: Voigt<T>, b: Voigt<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A unit vector perpendicular to `a`; any unit vector for a zero vector.
pub(crate) fn perpendicular(a: Vec3) -> Vec3 {
    let [x, y, z] = a.0.map(f64::abs);
    // The axis `a` has the smallest component along.
    let axis = if x <= y && x <= z {
        Vec3([1.0, 0.0, 0.0])
    } else if y <= z {
        Vec3([0.0, 1.0, 0.0])
    } else {
        Vec3([0.0, 0.0, 1.0])
    };
    let b = a.cross(axis);
    let norm = b.norm();
    if norm > 0.0 { b * (1.0 / norm) } else { Vec3([0.0, 1.0, 0.0]) }
}
