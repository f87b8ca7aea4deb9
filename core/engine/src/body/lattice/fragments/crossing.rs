//! Whether a triangle of the blade passes between two places: exact, and cheap where it is clear.

use pliant_solver::Vec3;
use robust::{Coord3D, orient3d};

/// Whether a segment passes through a triangle, edges included: decided exactly.
pub(super) fn crosses(from: Vec3, to: Vec3, triangle: &[Vec3; 3]) -> bool {
    !are_apart(&from, &to, triangle) && above(&from, triangle) != above(&to, triangle) && meets(from, to, triangle)
}

/// Which side of a triangle's plane a place is on. A middle on the blade itself counts as on its positive side, from wherever
/// it is looked at.
fn above(place: &Vec3, [a, b, c]: &[Vec3; 3]) -> bool {
    side(a, b, c, place) >= 0.0
}

/// The plane of a triangle, that places are soon told apart by.
pub(super) struct Plane<'a> {
    triangle: &'a [Vec3; 3],
    normal: Vec3,
    /// By the distance of a place from the first corner, summed over the axes: what rounding may make of the plane's side.
    doubt: f64,
}

impl<'a> Plane<'a> {
    pub(super) fn new(triangle: &'a [Vec3; 3]) -> Self {
        let [a, b, c] = triangle;
        let (ab, ac) = (b - a, c - a);
        let sum = |v: &Vec3| v.iter().fold(0.0, |sum, x| sum + x.abs());
        // Six products of three differences, each off by some six roundings: ninety are more than enough.
        Self { triangle, normal: ab.cross(&ac), doubt: 1e-14 * sum(&ab) * sum(&ac) }
    }

    /// As [`above`], and exact too.
    pub(super) fn is_above(&self, place: &Vec3) -> bool {
        let to = *place - self.triangle[0];
        let side = -self.normal.dot(&to);
        let doubt = self.doubt * to.iter().fold(0.0, |sum, x| sum + x.abs());
        if side.abs() > doubt { side > 0.0 } else { above(place, self.triangle) }
    }
}

/// Whether a coordinate alone parts a segment from a triangle: exact, and most often enough.
pub(super) fn are_apart(from: &Vec3, to: &Vec3, [a, b, c]: &[Vec3; 3]) -> bool {
    (0..3).any(|i| {
        let (low, high) = (from[i].min(to[i]), from[i].max(to[i]));
        a[i].min(b[i]).min(c[i]) > high || a[i].max(b[i]).max(c[i]) < low
    })
}

/// Whether the line through two places passes through a triangle.
pub(super) fn meets(from: Vec3, to: Vec3, [a, b, c]: &[Vec3; 3]) -> bool {
    let turns = [side(&from, &to, a, b), side(&from, &to, b, c), side(&from, &to, c, a)];
    turns.iter().all(|t| *t >= 0.0) || turns.iter().all(|t| *t <= 0.0)
}

fn side(p: &Vec3, q: &Vec3, r: &Vec3, s: &Vec3) -> f64 {
    let coord = |p: &Vec3| Coord3D { x: p[0], y: p[1], z: p[2] };
    orient3d(coord(p), coord(q), coord(r), coord(s))
}

/// Whether the plane of a triangle meets a cube, and the boxes of both meet: never no where they touch.
pub(super) fn plane_meets_box(triangle: &[Vec3; 3], middle: Vec3, half: f64) -> bool {
    for i in 0..3 {
        let low = triangle.iter().fold(f64::INFINITY, |m, p| m.min(p[i]));
        let high = triangle.iter().fold(-f64::INFINITY, |m, p| m.max(p[i]));
        if low > middle[i] + half || high < middle[i] - half {
            return false;
        }
    }
    let [a, b, c] = triangle;
    let normal = (b - a).cross(&(c - a));
    let distance = normal.dot(&(middle - triangle[0])).abs();
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
                assert_eq!(plane.is_above(&place), above(&place, &triangle), "{place:?}");
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
