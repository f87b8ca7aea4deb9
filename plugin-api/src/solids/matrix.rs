//! 3 x 3 matrices of scalars or vector registers.

use crate::lanes::{Real, Vec3};

/// A matrix by rows: `m[row][column]`.
pub type Mat3<T = f64> = [Vec3<T>; 3];

/// The identity matrix of three dimensions.
pub const IDENTITY: Mat3 = [Vec3([1.0, 0.0, 0.0]), Vec3([0.0, 1.0, 0.0]), Vec3([0.0, 0.0, 1.0])];

/// The product `m v` of a matrix and a vector.
#[inline(always)]
pub fn apply<T: Real>(m: &Mat3<T>, v: Vec3<T>) -> Vec3<T> {
    Vec3([m[0].dot(v), m[1].dot(v), m[2].dot(v)])
}

/// The product `a b` of two matrices.
#[inline(always)]
pub fn product<T: Real>(a: &Mat3<T>, b: &Mat3<T>) -> Mat3<T> {
    product_transposed(a, &transposed(b))
}

/// The product `a b^T`, of the first matrix with the second one transposed.
#[inline(always)]
pub fn product_transposed<T: Real>(a: &Mat3<T>, b: &Mat3<T>) -> Mat3<T> {
    let mut out = *a;
    for i in 0..3 {
        for j in 0..3 {
            out[i][j] = a[i].dot(b[j]);
        }
    }
    out
}

/// The transposed matrix `m^T`.
#[inline(always)]
pub fn transposed<T: Real>(m: &Mat3<T>) -> Mat3<T> {
    [Vec3([m[0][0], m[1][0], m[2][0]]), Vec3([m[0][1], m[1][1], m[2][1]]), Vec3([m[0][2], m[1][2], m[2][2]])]
}

/// Determinant of a 3 x 3 matrix.
#[inline(always)]
pub fn determinant<T: Real>(m: &Mat3<T>) -> T {
    m[0].dot(m[1].cross(m[2]))
}

/// The matrix of cofactors: the derivative of the determinant.
#[inline(always)]
pub fn cofactors<T: Real>(m: &Mat3<T>) -> Mat3<T> {
    [m[1].cross(m[2]), m[2].cross(m[0]), m[0].cross(m[1])]
}

/// Squared Frobenius norm: the sum of the squares of all entries.
#[inline(always)]
pub fn norm_squared<T: Real>(m: &Mat3<T>) -> T {
    m[0].dot(m[0]) + m[1].dot(m[1]) + m[2].dot(m[2])
}
