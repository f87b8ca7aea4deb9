//! Optimal triangulation of a convex polygon with vertices on its sides.

use pliant_mesh::geometry::Vec3;

/// A vertex of a polygon: its position, m, and the sides it lies on as a bit mask. Three vertices of one side form no triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub x: Vec3,
    pub sides: u8,
}

const MAX_VERTICES: usize = 120; // largest number of vertices; the cost is cubic

/// Triangles that maximise the smallest ratio of height to longest side, as indices into `polygon`, with its orientation. `None` for a polygon
/// without area or with too many vertices.
pub(super) fn triangulate(polygon: &[Vertex]) -> Option<Vec<[usize; 3]>> {
    let n = polygon.len();
    if !(3..=MAX_VERTICES).contains(&n) {
        return None;
    }
    let mut best = vec![f64::INFINITY; n * n]; // quality of the best triangulation of vertices i to j (n x n)
    let mut apex = vec![0; n * n];
    for span in 2..n {
        for i in 0..n - span {
            let j = i + span;
            let mut found = (-1.0, i + 1);
            for k in i + 1..j {
                let value = quality([polygon[i], polygon[k], polygon[j]]).min(best[i * n + k]).min(best[k * n + j]);
                if value > found.0 {
                    found = (value, k);
                }
            }
            (best[i * n + j], apex[i * n + j]) = found;
        }
    }
    if best[n - 1] <= 0.0 {
        return None;
    }
    let (mut triangles, mut waiting) = (Vec::with_capacity(n - 2), vec![(0, n - 1)]);
    while let Some((i, j)) = waiting.pop() {
        let k = apex[i * n + j];
        triangles.push([i, k, j]);
        waiting.extend([(k, j), (i, k)].into_iter().filter(|(from, to)| to - from > 1));
    }
    Some(triangles)
}

fn quality([a, b, c]: [Vertex; 3]) -> f64 {
    if a.sides & b.sides & c.sides != 0 {
        return -1.0;
    }
    let sides = [b.x - a.x, c.x - b.x, a.x - c.x];
    let longest = sides.iter().map(Vec3::norm_squared).fold(0.0, f64::max);
    sides[0].cross(&sides[1]).norm() / longest
}

/// Smallest angle of a triangle, degrees; 0 if two corners coincide.
pub(super) fn smallest_angle([a, b, c]: [Vec3; 3]) -> f64 {
    let sides = [b - a, c - b, a - c];
    let angle = |i: usize| {
        let (u, v) = (sides[i], -sides[(i + 2) % 3]);
        libm::atan2(u.cross(&v).norm(), u.dot(&v) + 0.0) // no minus zero
    };
    let least = (0..3).map(angle).fold(f64::INFINITY, f64::min);
    least.to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertex(x: f64, y: f64, sides: u8) -> Vertex {
        Vertex { x: Vec3::new(x, y, 0.0), sides }
    }

    #[test]
    fn no_triangle_lies_along_a_side() {
        let polygon = [
            vertex(0.0, 0.0, 0b101),
            vertex(0.3, 0.0, 0b001),
            vertex(0.6, 0.0, 0b001),
            vertex(1.0, 0.0, 0b011),
            vertex(0.5, 0.5, 0b010),
            vertex(0.0, 1.0, 0b110),
        ];
        let triangles = triangulate(&polygon).unwrap();
        assert_eq!(triangles.len(), 4);
        let area: f64 = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|at| polygon[at].x);
                0.5 * (b - a).cross(&(c - a)).z
            })
            .inspect(|area| assert!(*area > 0.01))
            .sum();
        assert!((area - 0.5).abs() < 1e-15);
        assert!(triangulate(&polygon[..4]).is_none(), "no area");
        assert!(triangulate(&polygon[..2]).is_none());
    }

    #[test]
    fn angles() {
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::new(1.0, 1.0, 0.0)];
        assert!((smallest_angle(corners) - 45.0).abs() < 1e-12);
        assert_eq!(smallest_angle([Vec3::x(); 3]), 0.0);
    }
}
