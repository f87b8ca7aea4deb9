//! The gradient of the angle of a hinge by its four corners.

use crate::algebra::Vec3;

/// Least height of a triangle over its edge's length for which the gradient is exact.
const MIN_ASPECT: f64 = 1e-6;

/// Gradient of the angle between the two triangles at the edge a, b, with the corner o to the left of it and p to the right, 1/m: at o and p one
/// over the height, and at the ends of the edge the vectors that make sum and moment zero. Finite for collapsed triangles.
pub fn gradient([a, b, o, p]: [Vec3; 4]) -> [Vec3; 4] {
    let [edge, to_left, to_right] = [b, o, p].map(|x| x - a);
    let (left, right) = (edge.cross(&to_left), to_right.cross(&edge));
    let square = edge.norm_squared().max(f64::MIN_POSITIVE);
    let floor = (square * square * (MIN_ASPECT * MIN_ASPECT)).max(f64::MIN_POSITIVE);
    let [go, gp] = [left, right].map(|n| -square.sqrt() * n / n.norm_squared().max(floor));
    // Position of the foot of each height along the edge: 0 at a, 1 at b.
    let (so, sp) = (to_left.dot(&edge) / square, to_right.dot(&edge) / square);
    let between = |s: f64, t: f64| -s * go - t * gp;
    [between(1.0 - so, 1.0 - sp), between(so, sp), go, gp]
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOLD: [Vec3; 4] =
        [Vec3::new(0.1, 0.0, 0.05), Vec3::new(0.9, 0.2, 0.0), Vec3::new(0.4, 0.8, 0.3), Vec3::new(0.7, -0.6, 0.2)];

    fn angle([a, b, o, p]: [Vec3; 4]) -> f64 {
        let [edge, to_left, to_right] = [b, o, p].map(|x| x - a);
        let (left, right) = (edge.cross(&to_left), to_right.cross(&edge));
        (left.cross(&right).dot(&edge) / edge.norm()).atan2(left.dot(&right))
    }

    #[test]
    fn the_gradient_is_the_difference_quotient() {
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
        assert!(gradient([Vec3::zeros(); 4]).iter().flatten().all(|c| c.is_finite()));
    }
}
