//! The angle between two triangles that share an edge.

use crate::arc::angle_of;
use crate::small::{V3, cross, dot, minus, mixed, scaled};

/// Least height of a triangle over its edge's length for which the gradient is exact.
const FLAT: f64 = 1e-6;

/// Of corners a, b, o, p, with the triangle a, b, o counter-clockwise seen from the front: rad, 0 when flat, positive where the
/// front is the outer side of the fold.
pub(crate) fn angle(x: [V3; 4]) -> f64 {
    let (edge, left, right) = normals(x);
    let size = dot(edge, edge).sqrt().max(f64::MIN_POSITIVE);
    angle_of(dot(cross(left, right), edge) / size, dot(left, right))
}

/// Its gradient, 1/m, by corner: 1 over the height at the two corners off the edge, and at the edge's ends what holds the sum
/// and the torque at zero.
pub(crate) fn gradient(x: [V3; 4]) -> [V3; 4] {
    let (edge, left, right) = normals(x);
    let [a, _, o, p] = x;
    let square = dot(edge, edge);
    let size = square.sqrt();
    let square = square.max(f64::MIN_POSITIVE);
    let floor = FLAT * FLAT * square * square;
    let steep = |n: V3| scaled(n, -size / dot(n, n).max(floor).max(f64::MIN_POSITIVE));
    let (go, gp) = (steep(left), steep(right));
    // Where the foot of each height is along the edge.
    let (so, sp) = (dot(minus(o, a), edge) / square, dot(minus(p, a), edge) / square);
    let end = |s: f64, t: f64| mixed(-s, go, -t, gp);
    [end(1.0 - so, 1.0 - sp), end(so, sp), go, gp]
}

/// The edge, m, and twice the area of each side along its normal, m^2.
fn normals([a, b, o, p]: [V3; 4]) -> (V3, V3, V3) {
    let edge = minus(b, a);
    (edge, cross(edge, minus(o, a)), cross(minus(p, a), edge))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOLD: [V3; 4] = [[0.1, 0.0, 0.05], [0.9, 0.2, 0.0], [0.4, 0.8, 0.3], [0.7, -0.6, 0.2]];

    #[test]
    fn gradient_is_the_slope() {
        let g = gradient(FOLD);
        for corner in 0..4 {
            for i in 0..3 {
                let at = |step: f64| {
                    let mut x = FOLD;
                    x[corner][i] += step;
                    angle(x)
                };
                let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
                assert!((slope - g[corner][i]).abs() < 1e-8, "{corner} {i}: {slope} {}", g[corner][i]);
                assert_ne!(slope, g[corner][i]);
            }
        }
    }

    #[test]
    fn flat_and_folded() {
        let at = |h: f64, y: f64| angle([[0.0; 3], [1.0, 0.0, 0.0], [0.3, 1.0, 0.0], [0.6, y, h]]);
        assert_eq!(at(0.0, -1.0), 0.0);
        // The front is up: a side that hangs down makes it the outer one.
        assert!((at(-1.0, 0.0) - std::f64::consts::FRAC_PI_2).abs() < 1e-12, "{}", at(-1.0, 0.0));
        assert!((at(1.0, 0.0) + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn collapsed_corners_stay_finite() {
        for x in [[[0.0; 3]; 4], [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.0, 0.0]]] {
            assert!(gradient(x).iter().flatten().all(|c| c.is_finite()) && angle(x).is_finite());
        }
    }
}
