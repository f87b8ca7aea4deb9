//! The dihedral angle between two triangles that share an edge.

use crate::atan2::atan2;
use crate::vector::Vec3;
use pliant_plugin_api::lanes::Real;

/// Least height of a triangle over its edge's length for which the gradient is exact.
const MIN_ASPECT: f64 = 1e-6;

/// The angle at the corners a, b, o, p of a hinge, rad, where the triangle a, b, o is counter-clockwise seen from the front: 0 when flat,
/// positive where the front is the outer side of the fold.
#[inline(always)]
pub(crate) fn angle<T: Real>(x: [Vec3<T>; 4]) -> T {
    let ScaledSinCos { sin, cos } = sin_cos(x);
    atan2(sin, cos)
}

/// Sine and cosine of an angle, times a common factor.
pub(crate) struct ScaledSinCos<T> {
    pub(crate) sin: T,
    pub(crate) cos: T,
}

/// Sine and cosine of [`angle`], times 4 A1 A2 with the areas of both triangles, m^4.
#[inline(always)]
pub(crate) fn sin_cos<T: Real>(x: [Vec3<T>; 4]) -> ScaledSinCos<T> {
    let Normals { edge, left, right } = normals(x);
    let [a, _, _, p] = x;
    // The cross product of both normals points along the edge; its length is the edge's times the volume the three sides span.
    ScaledSinCos { sin: -(edge.norm() * left.dot(p - a)), cos: left.dot(right) }
}

/// Gradient of [`angle`] by each corner, 1/m: at the corners opposite to the edge, 1 over the height; at the ends of the edge, what
/// makes the sum and the moment of the gradients zero.
#[inline(always)]
pub(crate) fn gradient<T: Real>(x: [Vec3<T>; 4]) -> [Vec3<T>; 4] {
    let Normals { edge, left, right } = normals(x);
    let [a, _, o, p] = x;
    let square = edge.dot(edge);
    let norm = square.sqrt();
    let (least, one) = (square.splat(f64::MIN_POSITIVE), square.splat(1.0));
    let square = square.max(least);
    let floor = square * square * (MIN_ASPECT * MIN_ASPECT);
    let (l, r) = (left.dot(left).max(floor), right.dot(right).max(floor));
    // One division in the place of three: multiplications are cheaper.
    let inverse = one / (l * r * square).max(least);
    let go = left * -(norm * (r * square) * inverse);
    let gp = right * -(norm * (l * square) * inverse);
    // Position of the foot of each height along the edge: 0 at a, 1 at b.
    let scale = l * r * inverse;
    let (so, sp) = ((o - a).dot(edge) * scale, (p - a).dot(edge) * scale);
    [go * -(one - so) + gp * -(one - sp), go * -so + gp * -sp, go, gp]
}

/// The edge, m, and the normals of both triangles with a length of twice their areas, m^2.
struct Normals<T> {
    edge: Vec3<T>,
    left: Vec3<T>,
    right: Vec3<T>,
}

#[inline(always)]
fn normals<T: Real>([a, b, o, p]: [Vec3<T>; 4]) -> Normals<T> {
    let edge = b - a;
    Normals { edge, left: edge.cross(o - a), right: (p - a).cross(edge) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOLD: [Vec3; 4] =
        [Vec3([0.1, 0.0, 0.05]), Vec3([0.9, 0.2, 0.0]), Vec3([0.4, 0.8, 0.3]), Vec3([0.7, -0.6, 0.2])];

    #[test]
    fn gradient_is_the_derivative_of_the_angle() {
        let g = gradient(FOLD);
        for corner in 0..4 {
            for i in 0..3 {
                let angle_at = |step: f64| {
                    let mut x = FOLD;
                    x[corner][i] += step;
                    angle(x)
                };
                let slope = (angle_at(1e-6) - angle_at(-1e-6)) / 2e-6;
                assert!((slope - g[corner][i]).abs() < 1e-8, "{corner} {i}: {slope} {}", g[corner][i]);
                assert_ne!(slope, g[corner][i]);
            }
        }
    }

    #[test]
    fn flat_and_right_angles() {
        let angle_at = |y: f64, z: f64| angle([[0.0; 3], [1.0, 0.0, 0.0], [0.3, 1.0, 0.0], [0.6, y, z]].map(Vec3));
        assert_eq!(angle_at(-1.0, 0.0), 0.0);
        // The front is up; a side that hangs down makes the front the outer side.
        let down = angle_at(0.0, -1.0);
        assert!((down - std::f64::consts::FRAC_PI_2).abs() < 1e-12, "{down}");
        assert!((angle_at(0.0, 1.0) + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn collapsed_corners_give_finite_results() {
        let point = [[0.0; 3]; 4];
        let line = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.0, 0.0]];
        for x in [point, line].map(|x| x.map(Vec3)) {
            let finite = gradient(x).iter().all(|g| g.0.iter().all(|c| c.is_finite()));
            assert!(finite && angle(x).is_finite());
        }
    }
}
