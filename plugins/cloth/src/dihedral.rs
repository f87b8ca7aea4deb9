//! The angle between two triangles that share an edge.

use crate::arc::angle_of;
use crate::small::{V3, cross, dot, minus, mixed, scaled};
use pliant_plugin_api::lanes::Real;

/// Least height of a triangle over its edge's length for which the gradient is exact.
const FLAT: f64 = 1e-6;

/// Of corners a, b, o, p, with the triangle a, b, o counter-clockwise seen from the front: rad, 0 when flat, positive where the
/// front is the outer side of the fold.
#[inline(always)]
pub(crate) fn angle<T: Real>(x: [V3<T>; 4]) -> T {
    let [y, x] = fold(x);
    angle_of(y, x)
}

/// Sine and cosine of that angle, times twice the areas of both sides, m^4.
#[inline(always)]
pub(crate) fn fold<T: Real>(x: [V3<T>; 4]) -> [T; 2] {
    let (edge, left, right) = normals(x);
    let [a, _, _, p] = x;
    // The product of both normals is along the edge, and by its length what all three sides from a span.
    [-(dot(edge, edge).sqrt() * dot(left, minus(p, a))), dot(left, right)]
}

/// Its gradient, 1/m, by corner: 1 over the height at the two corners off the edge, and at the edge's ends what holds the sum
/// and the torque at zero.
#[inline(always)]
pub(crate) fn gradient<T: Real>(x: [V3<T>; 4]) -> [V3<T>; 4] {
    let (edge, left, right) = normals(x);
    let [a, _, o, p] = x;
    let square = dot(edge, edge);
    let size = square.sqrt();
    let (least, one) = (square.splat(f64::MIN_POSITIVE), square.splat(1.0));
    let square = square.max(least);
    let floor = square * square * (FLAT * FLAT);
    let (l, r) = (dot(left, left).max(floor), dot(right, right).max(floor));
    // One division for three: products take less.
    let all = one / (l * r * square).max(least);
    let go = scaled(left, -(size * (r * square) * all));
    let gp = scaled(right, -(size * (l * square) * all));
    // Where the foot of each height is along the edge.
    let over = l * r * all;
    let (so, sp) = (dot(minus(o, a), edge) * over, dot(minus(p, a), edge) * over);
    [mixed(-(one - so), go, -(one - sp), gp), mixed(-so, go, -sp, gp), go, gp]
}

/// The edge, m, and twice the area of each side along its normal, m^2.
#[inline(always)]
fn normals<T: Real>([a, b, o, p]: [V3<T>; 4]) -> (V3<T>, V3<T>, V3<T>) {
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
        for x in [[[0.0_f64; 3]; 4], [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.0, 0.0]]] {
            assert!(gradient(x).iter().flatten().all(|c| c.is_finite()) && angle(x).is_finite());
        }
    }
}
