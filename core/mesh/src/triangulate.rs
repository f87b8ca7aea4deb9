//! Triangulation of polygons.

use crate::geometry::Vec3;

/// Adds the `polygon.len() - 2` triangles of a polygon (c x 3) with at least 3 corners, as indices of corners.
///
/// The triangles have the orientation of the polygon and do not overlap if its projection along its vector area is simple. A polygon without area, with
/// self-intersections, or with too many corners becomes a fan.
pub(super) fn triangulate(polygon: &[Vec3], pieces: &mut Vec<[usize; 3]>) {
    let Some(plane) = Plane::new(polygon) else {
        return fan(polygon.len(), pieces);
    };
    match polygon.len() {
        3 => pieces.push([0, 1, 2]),
        4 => plane.split_quad([0, 1, 2, 3], pieces),
        _ => {
            let start = pieces.len();
            if plane.clip_ears(pieces).is_none() {
                pieces.truncate(start);
                fan(polygon.len(), pieces);
            }
        }
    }
}

/// Whether a quad (4 x 3) has no corner that turns inwards.
pub(super) fn is_convex(quad: &[Vec3; 4]) -> bool {
    Plane::new(quad).is_some_and(|plane| SPLITS.iter().all(|split| plane.least_turn(split) > plane.small))
}

/// Splits a quad (4 x 3) along the diagonal that is no side of the triangle `half`; `None` if that would invert a triangle.
pub(super) fn split_otherwise(quad: &[Vec3; 4], half: [usize; 3]) -> Option<[[usize; 3]; 2]> {
    let plane = Plane::new(quad)?;
    let [ac, bd] = SPLITS;
    let other = if ac.contains(&half) { bd } else { ac };
    (plane.least_turn(&other) > plane.small).then_some(other)
}

/// The two ways to split a quad.
const SPLITS: [[[usize; 3]; 2]; 2] = [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]];

fn fan(corners: usize, pieces: &mut Vec<[usize; 3]>) {
    pieces.extend((2..corners).map(|corner| [0, corner - 1, corner]));
}

/// The projection of a polygon along its vector area, counter-clockwise.
struct Plane<'a> {
    polygon: &'a [Vec3],
    normal: Vec3, // unit
    small: f64,   // twice the area that counts as zero, square units
}

/// Largest number of point-in-triangle tests for one polygon; enough for 10,000 corners of which every second one is reflex.
const MAX_TESTS: usize = 200_000_000;

impl<'a> Plane<'a> {
    fn new(polygon: &'a [Vec3]) -> Option<Self> {
        let spokes = polygon[1..].windows(2).map(|pair| (pair[0] - polygon[0]).cross(&(pair[1] - polygon[0])));
        let twice_area: Vec3 = spokes.sum();
        let reach = polygon.iter().map(|point| (point - polygon[0]).norm_squared()).fold(0.0, f64::max);
        let small = 1e-12 * reach;
        let normal = twice_area.try_normalize(small)?;
        Some(Self { polygon, normal, small })
    }

    /// Twice the signed area of the triangle `a b c`.
    fn turn(&self, a: usize, b: usize, c: usize) -> f64 {
        let [a, b, c] = [a, b, c].map(|corner| self.polygon[corner]);
        (b - a).cross(&(c - a)).dot(&self.normal)
    }

    fn least_turn(&self, pieces: &[[usize; 3]]) -> f64 {
        pieces.iter().map(|&[a, b, c]| self.turn(a, b, c)).fold(f64::INFINITY, f64::min)
    }

    fn split_quad(&self, corners: [usize; 4], pieces: &mut Vec<[usize; 3]>) {
        let [ac, bd] = SPLITS.map(|split| split.map(|piece| piece.map(|corner| corners[corner])));
        let [a, b, c, d] = corners.map(|corner| self.polygon[corner]);
        let best = match [ac, bd].map(|split| self.least_turn(&split) > self.small) {
            [true, false] => ac,
            [false, true] => bd,
            _ if (d - b).norm_squared() < (c - a).norm_squared() => bd,
            _ => ac,
        };
        pieces.extend(best);
    }

    /// Ear clipping: cuts off corners whose triangle contains no other corner until a quad remains; `None` if there is no such corner.
    fn clip_ears(&self, pieces: &mut Vec<[usize; 3]>) -> Option<()> {
        let count = self.polygon.len();
        let mut next: Vec<usize> = (1..count).chain([0]).collect();
        let mut previous: Vec<usize> = [count - 1].into_iter().chain(0..count - 1).collect();
        let convex = |a, b, c| self.turn(a, b, c) > self.small;
        // Only reflex and flat corners can lie in an ear.
        let mut inward: Vec<usize> = (0..count).filter(|&b| !convex(previous[b], b, next[b])).collect();
        let (mut left, mut misses, mut work) = (count, 0, 0);
        let mut b = 0;
        while left > 4 {
            let (a, c) = (previous[b], next[b]);
            work += inward.len();
            if misses > left || work > MAX_TESTS {
                return None;
            }
            if !convex(a, b, c) || inward.iter().any(|&corner| self.covers([a, b, c], corner)) {
                misses += 1;
                b = c;
                continue;
            }
            pieces.push([a, b, c]);
            (next[a], previous[c]) = (c, a);
            left -= 1;
            misses = 0;
            inward.retain(|&corner| corner != a && corner != c || !convex(previous[corner], corner, next[corner]));
            b = next[c]; // skips a corner, so that a round polygon does not become a fan of slivers
        }
        self.split_quad([b, next[b], next[next[b]], previous[b]], pieces);
        Some(())
    }

    /// Whether `corner` lies in or on the triangle, except at its corners.
    fn covers(&self, [a, b, c]: [usize; 3], corner: usize) -> bool {
        let point = self.polygon[corner];
        let sides = [(a, b), (b, c), (c, a)];
        sides.iter().all(|&(from, to)| self.turn(from, to, corner) >= -self.small)
            && [a, b, c].iter().all(|&other| self.polygon[other] != point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// The pieces of a polygon in the plane, checked: right count, none turned over, areas adding up.
    #[track_caller]
    fn pieces(outline: &[[f64; 2]]) -> Vec<[usize; 3]> {
        let tilt = nalgebra::Rotation3::from_euler_angles(0.5, 0.6, 0.7);
        let polygon: Vec<_> = outline.iter().map(|p| tilt * Vec3::new(p[0], p[1], 3.0)).collect();
        let mut pieces = Vec::new();
        triangulate(&polygon, &mut pieces);
        assert_eq!(pieces.len(), polygon.len() - 2);
        let plane = Plane::new(&polygon).unwrap();
        let turns: Vec<f64> = pieces.iter().map(|&[a, b, c]| plane.turn(a, b, c)).collect();
        assert!(turns.iter().all(|&turn| turn > plane.small), "{turns:?}");
        let area: f64 = (2..polygon.len()).map(|c| plane.turn(0, c - 1, c)).sum();
        assert!((turns.iter().sum::<f64>() - area).abs() < 1e-9 * area, "pieces overlap");
        pieces
    }

    #[test]
    fn quads_take_the_shorter_inner_diagonal() {
        assert_eq!(pieces(&[[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [1.0, 1.0]])[0], [0, 1, 3], "the shorter");
        assert_eq!(pieces(&[[0.0, 0.0], [1.0, -2.0], [0.3, 0.0], [1.0, 2.0]])[0], [0, 1, 2], "concave at 2");
        assert_eq!(pieces(&[[1.0, -2.0], [0.3, 0.0], [1.0, 2.0], [0.0, 0.0]])[0], [0, 1, 3], "concave at 1");
        assert_eq!(pieces(&[[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.5, 9.0]])[0], [0, 1, 3], "flat at 1");
    }

    #[test]
    fn concave_and_flat_polygons() {
        pieces(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]]);
        pieces(&[[2.0, 1.0], [0.0, 4.0], [0.0, 0.0], [4.0, 0.0], [4.0, 4.0]]);
        pieces(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [1.5, 1.0]]);
        pieces(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.5, 1.0], [1.0, 2.0], [0.5, 1.0]]);
        let comb = (0..40).map(|i| [f64::from(i), if i % 2 == 0 { 5.0 } else { 0.5 }]);
        pieces(&comb.rev().chain([[0.0, 0.0], [39.0, 0.0]]).collect::<Vec<_>>());
    }

    #[test]
    fn random_star_polygons() {
        let mut random = Random(3);
        for corners in (5..40).cycle().take(500) {
            let angle = |i| std::f64::consts::TAU * f64::from(i) / f64::from(corners);
            let star = (0..corners).map(|i| {
                let radius = 0.2 + random.unit();
                [radius * angle(i).cos(), radius * angle(i).sin()]
            });
            pieces(&star.collect::<Vec<_>>());
        }
    }

    #[test]
    fn what_has_no_area_becomes_a_fan() {
        let line: Vec<_> = (0..6).map(|i| Vec3::new(f64::from(i), 0.0, 0.0)).collect();
        let mut fan = Vec::new();
        triangulate(&line, &mut fan);
        assert_eq!(fan, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
    }

    #[test]
    fn a_polygon_of_many_corners_ends_soon() {
        let corners = 20_000;
        let angle = |i| std::f64::consts::TAU * f64::from(i) / f64::from(corners);
        pieces(&(0..corners).map(|i| [angle(i).cos(), angle(i).sin()]).collect::<Vec<_>>());
    }
}
