//! What a hinge does to its four corners: the gradient of its angle.

use crate::algebra::{V3, axpy, dot};

/// Least height of a triangle over its edge's length for which the gradient is exact.
const FLAT: f64 = 1e-6;

/// `a x b`
#[inline(always)]
pub fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Of the angle between the triangles beside the edge a, b, with the corner o to the left of it and p to the right, 1/m: 1 over
/// the height at the corners off the edge, and at its ends what holds the sum and the torque at zero. Finite if they collapse.
pub fn gradient([a, b, o, p]: [V3; 4]) -> [V3; 4] {
    let [edge, to_left, to_right] = [b, o, p].map(|x| axpy(x, -1.0, a));
    let (left, right) = (cross(edge, to_left), cross(to_right, edge));
    let square = dot(edge, edge).max(f64::MIN_POSITIVE);
    let floor = (square * square * (FLAT * FLAT)).max(f64::MIN_POSITIVE);
    let [go, gp] = [left, right].map(|n| n.map(|c| -square.sqrt() * c / dot(n, n).max(floor)));
    // Where the foot of each height is along the edge.
    let (so, sp) = (dot(to_left, edge) / square, dot(to_right, edge) / square);
    let between = |s: f64, t: f64| axpy(go.map(|c| -s * c), -t, gp);
    [between(1.0 - so, 1.0 - sp), between(so, sp), go, gp]
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOLD: [V3; 4] = [[0.1, 0.0, 0.05], [0.9, 0.2, 0.0], [0.4, 0.8, 0.3], [0.7, -0.6, 0.2]];

    fn angle([a, b, o, p]: [V3; 4]) -> f64 {
        let [edge, to_left, to_right] = [b, o, p].map(|x| axpy(x, -1.0, a));
        let (left, right) = (cross(edge, to_left), cross(to_right, edge));
        (dot(cross(left, right), edge) / dot(edge, edge).sqrt()).atan2(dot(left, right))
    }

    #[test]
    fn gradient_is_the_slope() {
        let g = gradient(FOLD);
        for (corner, i) in (0..4).flat_map(|corner| (0..3).map(move |i| (corner, i))) {
            let at = |step: f64| {
                let mut x = FOLD;
                x[corner][i] += step;
                angle(x)
            };
            let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
            assert!((slope - g[corner][i]).abs() < 1e-8, "{corner} {i}: {slope} {}", g[corner][i]);
            assert_ne!(slope, g[corner][i]);
        }
        assert!(gradient([[0.0; 3]; 4]).iter().flatten().all(|c| c.is_finite()));
    }
}
