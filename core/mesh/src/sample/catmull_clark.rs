//! Catmull-Clark subdivision of a closed cage (Catmull and Clark, 1978).

use std::collections::BTreeMap;

use super::cage::{Cage, Quad};
use crate::geometry::Vec3;

/// Every quad of a closed cage cut into four and smoothed.
///
/// Points: the old ones, moved; then one for each quad; then one for each edge. Quad q becomes 4 q to 4 q + 3, one for
/// each of its corners, of the same part.
pub(super) fn subdivide(cage: &Cage) -> Cage {
    let count = cage.points.len();
    let mut points = vec![Vec3::zeros(); count];
    let at = |corner: u32| cage.points[corner as usize];
    let mut edges: BTreeMap<[u32; 2], (u32, Vec3)> = BTreeMap::new(); // number, sum of quad points beside it
    let mut valence = vec![0.0; count];
    let key = |a: u32, b: u32| [a.min(b), a.max(b)];
    for quad in &cage.quads {
        let middle = quad.corners.map(at).iter().sum::<Vec3>() / 4.0;
        points.push(middle);
        for (corner, next) in sides(quad) {
            let number = edges.len() as u32;
            edges.entry(key(corner, next)).or_insert((number, Vec3::zeros())).1 += middle;
            // A corner's part of Q + 2 R: quad points, and edge middles, each met once by this sense of its sides.
            points[corner as usize] += middle + (at(corner) + at(next));
            valence[corner as usize] += 1.0;
        }
    }
    for (index, n) in valence.iter().enumerate() {
        points[index] = (points[index] / *n + (n - 3.0) * cage.points[index]) / *n;
    }
    let first_quad = count as u32;
    let first_edge = points.len() as u32;
    points.resize(points.len() + edges.len(), Vec3::zeros());
    for (&[a, b], &(number, beside)) in &edges {
        points[(first_edge + number) as usize] = (at(a) + at(b) + beside) / 4.0;
    }
    let edge_point = |a: u32, b: u32| first_edge + edges[&key(a, b)].0;
    let quarters = (first_quad..).zip(&cage.quads).flat_map(|(middle, quad)| {
        let [a, b, c, d] = quad.corners;
        [[d, a, b], [a, b, c], [b, c, d], [c, d, a]].map(|[before, corner, after]| Quad {
            corners: [corner, edge_point(corner, after), middle, edge_point(before, corner)],
            ..*quad
        })
    });
    Cage { quads: quarters.collect(), points }
}

fn sides(quad: &Quad) -> [(u32, u32); 4] {
    [0, 1, 2, 3].map(|corner| (quad.corners[corner], quad.corners[(corner + 1) % 4]))
}

#[cfg(test)]
mod tests {
    use super::super::cage::Ring;
    use super::*;

    /// A cube of side 2 about the origin.
    fn cube() -> Cage {
        let ring = |z| (Ring { at: [0.0, 0.0, z], facing: [0.0, 0.0, 1.0], half: [2.0_f64.sqrt(); 2] }, 0);
        Cage::body(&[ring(-1.0), ring(1.0)], [0.0, 1.0, 0.0], 1)
    }

    #[test]
    fn the_cube_after_one_step_is_the_book_s() {
        let cube = cube();
        assert!(cube.points.iter().all(|point| point.iter().all(|part| (part.abs() - 1.0).abs() < 1e-14)));
        let fine = subdivide(&cube);
        assert_eq!((fine.points.len(), fine.quads.len()), (26, 24));
        let near = |point: &Vec3, norm: f64| (point.norm() - norm).abs() < 1e-14;
        // Corner (5/9)^3, side (0, 3/4, 3/4), middle (0, 0, 1).
        assert!(fine.points[..8].iter().all(|point| near(point, 5.0 / 9.0 * 3.0_f64.sqrt())));
        assert!(fine.points[8..14].iter().all(|point| near(point, 1.0)));
        assert!(fine.points[14..].iter().all(|point| near(point, 0.75 * 2.0_f64.sqrt())));
    }

    #[test]
    fn quads_keep_facing_outward() {
        let mut cage = cube();
        for _ in 0..3 {
            cage = subdivide(&cage);
        }
        assert_eq!(cage.quads.len(), 6 * 64);
        for quad in 0..cage.quads.len() {
            let middle = cage.points[cage.quads[quad].corners[0] as usize];
            assert!(cage.normal(quad).dot(&middle) > 0.0);
        }
    }
}
