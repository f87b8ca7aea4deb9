//! Three-dimensional vectors of scalars or vector registers.

use super::Real;
use core::ops::{Add, Index, IndexMut, Mul, Neg, Sub};

/// A vector in space; with vector registers, one for each lane.
///
/// An operator does what it does for each component, in the order x, y, z, without fused multiply-adds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(transparent)]
pub struct Vec3<T = f64>(pub [T; 3]);

impl<T> From<[T; 3]> for Vec3<T> {
    #[inline(always)]
    fn from(components: [T; 3]) -> Self {
        Self(components)
    }
}

impl<T> Index<usize> for Vec3<T> {
    type Output = T;
    #[inline(always)]
    fn index(&self, axis: usize) -> &T {
        &self.0[axis]
    }
}

impl<T> IndexMut<usize> for Vec3<T> {
    #[inline(always)]
    fn index_mut(&mut self, axis: usize) -> &mut T {
        &mut self.0[axis]
    }
}

impl<T: Real> Add for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self([self[0] + other[0], self[1] + other[1], self[2] + other[2]])
    }
}

impl<T: Real> Sub for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self([self[0] - other[0], self[1] - other[1], self[2] - other[2]])
    }
}

impl<T: Real> Neg for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self([-self[0], -self[1], -self[2]])
    }
}

impl<T: Real> Mul<T> for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self([factor * self[0], factor * self[1], factor * self[2]])
    }
}

impl<T: Real> Vec3<T> {
    /// Scalar product, summed in the order x, y, z.
    #[inline(always)]
    pub fn dot(self, other: Self) -> T {
        self[0] * other[0] + self[1] * other[1] + self[2] * other[2]
    }

    /// Vector product of `self` and `other`, in this order.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self([
            self[1] * other[2] - self[2] * other[1],
            self[2] * other[0] - self[0] * other[2],
            self[0] * other[1] - self[1] * other[0],
        ])
    }

    /// Euclidean length of the vector.
    #[inline(always)]
    pub fn norm(self) -> T {
        self.dot(self).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_two_vectors() {
        let (a, b) = (Vec3([1.0, 2.0, 3.0]), Vec3([-2.0, 0.5, 4.0]));
        let c = a.cross(b);
        assert_eq!((a.dot(b), c.dot(a), c.dot(b)), (11.0, 0.0, 0.0));
        assert_eq!(c.dot(c), a.dot(a) * b.dot(b) - a.dot(b) * a.dot(b));
        assert_eq!((a + b - b, -(-a), (a * 2.0).norm()), (a, a, 2.0 * a.norm()));
    }
}
