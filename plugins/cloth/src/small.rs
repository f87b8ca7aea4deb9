//! Vectors of space and of the sheet.

use pliant_plugin_api::lanes::Real;

pub(crate) type V2<T = f64> = [T; 2];
pub(crate) type V3<T = f64> = [T; 3];

/// `m[row][column]`
pub(crate) type M2<T = f64> = [[T; 2]; 2];
pub(crate) type M3<T = f64> = [[T; 3]; 3];

#[inline(always)]
pub(crate) fn dot<T: Real>(a: V3<T>, b: V3<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cross<T: Real>(a: V3<T>, b: V3<T>) -> V3<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub(crate) fn minus<T: Real>(a: V3<T>, b: V3<T>) -> V3<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn scaled<T: Real>(a: V3<T>, by: T) -> V3<T> {
    [by * a[0], by * a[1], by * a[2]]
}

/// `p a + q b`
#[inline(always)]
pub(crate) fn mixed<T: Real>(p: T, a: V3<T>, q: T, b: V3<T>) -> V3<T> {
    [p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2]]
}

/// All of them `by` times.
#[inline(always)]
pub(crate) fn times<T: Real>(a: [T; 3], by: f64) -> [T; 3] {
    [a[0] * by, a[1] * by, a[2] * by]
}

#[inline(always)]
pub(crate) fn length<T: Real>(a: V3<T>) -> T {
    dot(a, a).sqrt()
}

/// A unit vector across `a`, whatever `a` is.
pub(crate) fn across(a: V3) -> V3 {
    let least = if a[0].abs() <= a[1].abs() && a[0].abs() <= a[2].abs() {
        [1.0, 0.0, 0.0]
    } else if a[1].abs() <= a[2].abs() {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let b = cross(a, least);
    let size = length(b);
    if size > 0.0 { scaled(b, 1.0 / size) } else { [0.0, 1.0, 0.0] }
}
