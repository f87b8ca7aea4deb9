//! The closest point of a triangle, by its seven Voronoi regions (Ericson 2005).

use super::Vec3;

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The nearest point of the triangle, m.
    pub point: Vec3,
    /// Barycentric coordinates in the triangle: weights of its three corners, sum 1.
    pub bary: Vec3,
}

/// The point of triangle `abc` closest to `p`.
pub fn closest_point(p: Vec3, [a, b, c]: [Vec3; 3]) -> Closest {
    let (ab, ac) = (b - a, c - a);
    let at = |v: f64, w: f64| Closest { point: a + v * ab + w * ac, bary: Vec3::new(1.0 - v - w, v, w) };
    let ap = p - a;
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return at(0.0, 0.0);
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return at(1.0, 0.0);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return at(d1 / (d1 - d3), 0.0);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return at(0.0, 1.0);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return at(0.0, d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return at(1.0 - w, w);
    }
    let sum = va + vb + vc;
    at(vb / sum, vc / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_sampled_point_of_the_triangle_is_closer() {
        let triangle = [Vec3::zeros(), Vec3::new(2.0, 0.1, 0.0), Vec3::new(0.3, 1.5, 0.4)];
        let mut regions = std::collections::BTreeSet::new();
        for i in 0..400 {
            let f = |k: f64| 4.0 * ((f64::from(i) * k).sin());
            let p = Vec3::new(f(1.3), f(2.7), f(0.9));
            let found = closest_point(p, triangle);
            regions.insert(<[bool; 3]>::from(found.bary.map(|b| b > 1e-12)));
            assert!((found.bary.iter().sum::<f64>() - 1.0).abs() < 1e-12 && found.bary.iter().all(|b| *b >= -1e-12));
            let distance = |q: Vec3| (p - q).norm_squared().sqrt();
            let best = distance(found.point);
            for u in 0..=20 {
                for v in 0..=20 - u {
                    let (v, w) = (f64::from(u) / 20.0, f64::from(v) / 20.0);
                    let q =
                        Vec3::from_fn(|i, _| (1.0 - v - w) * triangle[0][i] + v * triangle[1][i] + w * triangle[2][i]);
                    assert!(distance(q) >= best - 1e-12);
                }
            }
        }
        assert_eq!(regions.len(), 7, "all seven regions were met");
    }

    #[test]
    fn a_triangle_without_area_still_has_a_closest_point() {
        let found = closest_point(
            Vec3::new(1.0, 1.0, 0.0),
            [Vec3::zeros(), Vec3::new(2.0, 0.0, 0.0), Vec3::new(2.0, 0.0, 0.0)],
        );
        assert!(found.point.iter().all(|c| c.is_finite()) && (found.point[0] - 1.0).abs() < 1e-12);
    }
}
