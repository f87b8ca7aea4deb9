//! Exact tests of segments against triangles, with cheap filters before the exact arithmetic (Shewchuk 1997).

use pliant_solver::Vec3;
use robust::{Coord3D, orient3d};

/// Whether a segment crosses a triangle, edges included; exact.
pub(super) fn crosses(from: Vec3, to: Vec3, triangle: &[Vec3; 3]) -> bool {
    !are_apart(&from, &to, triangle)
        && is_above(&from, triangle) != is_above(&to, triangle)
        && line_meets(from, to, triangle)
}

/// Whether a point is on the positive side of a triangle's plane; exact. A point on the plane counts as positive, whichever segment it
/// ends.
fn is_above(point: &Vec3, [a, b, c]: &[Vec3; 3]) -> bool {
    orientation(a, b, c, point) >= 0.0
}

/// The plane of a triangle, with an error bound that makes most tests cheap.
pub(super) struct Plane<'a> {
    triangle: &'a [Vec3; 3],
    /// Twice the area vector, m^2.
    normal: Vec3,
    /// Bound of the rounding error of the signed volume, m^3, for each metre of a point's distance from the first corner in the 1-norm.
    error_bound: f64,
}

impl<'a> Plane<'a> {
    /// The plane of a triangle, m.
    pub(super) fn new(triangle: &'a [Vec3; 3]) -> Self {
        let [a, b, c] = triangle;
        let (ab, ac) = (b - a, c - a);
        let norm = |v: &Vec3| v.iter().fold(0.0, |sum, x| sum + x.abs());
        // Six products of three differences, each with about six roundings: 36 times 1.1e-16, and a factor of two.
        Self { triangle, normal: ab.cross(&ac), error_bound: 1e-14 * norm(&ab) * norm(&ac) }
    }

    /// The same as [`is_above`], and as exact: exact arithmetic decides where the error bound does not.
    pub(super) fn is_above(&self, point: &Vec3) -> bool {
        let to = *point - self.triangle[0];
        let volume = -self.normal.dot(&to);
        let error_bound = self.error_bound * to.iter().fold(0.0, |sum, x| sum + x.abs());
        if volume.abs() > error_bound { volume > 0.0 } else { is_above(point, self.triangle) }
    }
}

/// Whether the bounding boxes of a segment and a triangle are disjoint; exact.
pub(super) fn are_apart(from: &Vec3, to: &Vec3, [a, b, c]: &[Vec3; 3]) -> bool {
    (0..3).any(|i| {
        let (low, high) = (from[i].min(to[i]), from[i].max(to[i]));
        a[i].min(b[i]).min(c[i]) > high || a[i].max(b[i]).max(c[i]) < low
    })
}

/// Whether the line through two points meets a triangle, edges included; exact.
pub(super) fn line_meets(from: Vec3, to: Vec3, [a, b, c]: &[Vec3; 3]) -> bool {
    let sides = [orientation(&from, &to, a, b), orientation(&from, &to, b, c), orientation(&from, &to, c, a)];
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

/// Sign of the volume of a tetrahedron; exact.
fn orientation(p: &Vec3, q: &Vec3, r: &Vec3, s: &Vec3) -> f64 {
    let coord = |p: &Vec3| Coord3D { x: p[0], y: p[1], z: p[2] };
    orient3d(coord(p), coord(q), coord(r), coord(s))
}

/// Whether the plane of a triangle meets a cube around `centre` with half-edge `half`, and their bounding boxes meet. Contact counts.
pub(super) fn plane_meets_box(triangle: &[Vec3; 3], centre: Vec3, half: f64) -> bool {
    for i in 0..3 {
        let low = triangle.iter().fold(f64::INFINITY, |m, p| m.min(p[i]));
        let high = triangle.iter().fold(-f64::INFINITY, |m, p| m.max(p[i]));
        if low > centre[i] + half || high < centre[i] - half {
            return false;
        }
    }
    let [a, b, c] = triangle;
    let normal = (b - a).cross(&(c - a));
    let distance = normal.dot(&(centre - triangle[0])).abs();
    distance <= half * (normal[0].abs() + normal[1].abs() + normal[2].abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_tells_sides_as_the_exact_test_does() {
        let triangle = [Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.0, 0.1, -0.2), Vec3::new(0.3, 1.1, 0.7)];
        let [a, b, c] = triangle;
        let (plane, normal) = (Plane::new(&triangle), (b - a).cross(&(c - a)));
        for i in 0..2000 {
            let (s, t) = (f64::from(i % 40) / 13.0 - 1.0, f64::from(i / 40) / 17.0 - 1.0);
            for off in [0.0, 1e-17, -1e-16, 1e-15, -1e-12, 0.3, -0.3] {
                let place = a + s * (b - a) + t * (c - a) + off * normal;
                assert_eq!(plane.is_above(&place), is_above(&place, &triangle), "{place:?}");
            }
        }
    }

    #[test]
    fn crossings_are_the_same_from_both_ends() {
        let triangle = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        for (p, q, expected) in [
            ([0.2, 0.2, -1.0], [0.2, 0.2, 1.0], true),
            ([0.2, 0.2, 0.0], [0.2, 0.2, 1.0], true),
            ([0.2, 0.2, 0.0], [0.2, 0.2, -1.0], false),
            ([0.8, 0.8, -1.0], [0.8, 0.8, 1.0], false),
        ] {
            let (p, q) = (Vec3::from(p), Vec3::from(q));
            assert_eq!(crosses(p, q, &triangle), expected);
            assert_eq!(crosses(q, p, &triangle), expected);
        }
    }
}
