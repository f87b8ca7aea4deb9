//! Vectors of space and of the sheet.

pub(crate) type V2 = [f64; 2];
pub(crate) type V3 = [f64; 3];

/// `m[row][column]`
pub(crate) type M2 = [[f64; 2]; 2];
pub(crate) type M3 = [[f64; 3]; 3];

pub(crate) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn minus(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scaled(a: V3, by: f64) -> V3 {
    [by * a[0], by * a[1], by * a[2]]
}

/// `p a + q b`
pub(crate) fn mixed(p: f64, a: V3, q: f64, b: V3) -> V3 {
    [p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2]]
}

pub(crate) fn length(a: V3) -> f64 {
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
