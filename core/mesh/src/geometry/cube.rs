//! Whether a triangle meets a cube, by separating axes (Akenine-Moeller 2001).

use super::Vec3;

/// Whether a triangle meets the closed cube with this centre and half-size, in the units of the points.
pub fn meets_cube(corners: [Vec3; 3], centre: Vec3, half: f64) -> bool {
    let [a, b, c] = corners.map(|corner| corner - centre);
    let is_apart = |axis: Vec3| {
        let [p, q, r] = [a, b, c].map(|corner| axis.dot(&corner));
        let reach = half * axis.abs().sum();
        p.min(q).min(r) > reach || p.max(q).max(r) < -reach
    };
    let sides = [b - a, c - b, a - c];
    let units = [Vec3::x(), Vec3::y(), Vec3::z()];
    let crossed = |unit: Vec3| sides.iter().any(|side| is_apart(unit.cross(side)));
    !(units.into_iter().any(is_apart) || is_apart(sides[0].cross(&sides[1])) || units.into_iter().any(crossed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// Whether something of a triangle is left after it was cut off at the six faces of a cube about the origin (Sutherland and Hodgman 1974).
    fn is_something_left(corners: [Vec3; 3], half: f64) -> bool {
        let mut polygon = corners.to_vec();
        for (axis, side) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
            let beyond = |p: &Vec3| side * p[axis] - half;
            let mut kept = Vec::new();
            for (i, p) in polygon.iter().enumerate() {
                let q = polygon[(i + 1) % polygon.len()];
                let (from, to) = (beyond(p), beyond(&q));
                if from <= 0.0 {
                    kept.push(*p);
                }
                if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
                    kept.push(p + from / (from - to) * (q - p));
                }
            }
            polygon = kept;
        }
        !polygon.is_empty()
    }

    #[test]
    fn triangles_meet_a_cube_where_clipping_leaves_something() {
        let (mut random, mut counts) = (Random(5), [0, 0]);
        for round in 0..20_000 {
            let size = [0.2, 1.0, 5.0][round % 3];
            let mut point = |scale: f64| Vec3::from_fn(|_, _| scale * (2.0 * random.unit() - 1.0));
            let middle = point(2.0);
            let corners = [0, 1, 2].map(|_| middle + point(size));
            let found = meets_cube(corners, Vec3::zeros(), 1.0);
            assert_eq!(found, is_something_left(corners, 1.0), "{corners:?}");
            let moved = Vec3::new(30.0, -7.0, 0.5);
            assert_eq!(meets_cube(corners.map(|corner| corner + moved), moved, 1.0), found, "{corners:?}");
            counts[usize::from(found)] += 1;
        }
        assert!(counts[0] > 2000 && counts[1] > 2000, "{counts:?}");
    }

    #[test]
    fn a_triangle_in_a_face_meets_the_cube_and_one_beyond_does_not() {
        let face = [[1.0, 0.0, 0.0], [1.0, 0.5, 0.0], [1.0, 0.0, 0.5]].map(Vec3::from);
        assert!(meets_cube(face, Vec3::zeros(), 1.0));
        assert!(!meets_cube(face, Vec3::zeros(), 1.0 - 1e-9));
    }
}
