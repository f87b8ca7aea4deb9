//! Surfaces that cut through each other.

use super::surface::{CollisionSurface, NO_EDGE};
use pliant_solver::Vec3;

/// Number of edges that go through triangles between two surfaces with vertices at `x` and `y` (m). With `is_same` they are one surface, and features that share a
/// vertex do not count. Boxes of the trees must be up to date.
pub(super) fn count_crossings(
    [a, b]: [&CollisionSurface; 2],
    [x, y]: [&[Vec3]; 2],
    is_same: bool,
    stack: &mut Vec<[u32; 2]>,
) -> usize {
    let mut count = 0;
    let mut one_way = |of: &CollisionSurface, at: &[Vec3], s: u32, other: &CollisionSurface, to: &[Vec3], t: u32| {
        let corners = other.triangles[t as usize];
        for e in of.own_edges[s as usize].into_iter().filter(|e| *e != NO_EDGE) {
            let ends = of.edges[e as usize];
            let is_shared = is_same && ends.iter().any(|v| corners.contains(v));
            let goes_through = || pierces(ends.map(|v| at[v as usize]), corners.map(|v| to[v as usize]));
            count += usize::from(!is_shared && goes_through());
        }
    };
    let visit = |s: u32, t: u32| {
        one_way(a, x, s, b, y, t);
        one_way(b, y, t, a, x, s);
    };
    match is_same {
        true => a.tree.own_pairs(0.0, stack, visit),
        false => a.tree.pairs(&b.tree, 0.0, stack, visit),
    }
    count
}

/// Whether a segment goes through a triangle; touching does not count.
fn pierces([p, q]: [Vec3; 2], [a, b, c]: [Vec3; 3]) -> bool {
    let volume = |p: Vec3, q: Vec3, r: Vec3, s: Vec3| (q - p).cross(&(r - p)).dot(&(s - p));
    let sides = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    let is_through = sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0);
    is_through && volume(a, b, c, p) * volume(a, b, c, q) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_pierces_what_it_goes_through() {
        let triangle = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        let segment = |x: f64, y: f64, low: f64, high: f64| [Vec3::new(x, y, low), Vec3::new(x, y, high)];
        assert!(pierces(segment(0.2, 0.2, -1.0, 1.0), triangle) && pierces(segment(0.2, 0.2, 1.0, -1.0), triangle));
        assert!(!pierces(segment(0.2, 0.2, 0.1, 1.0), triangle), "it ends above");
        assert!(!pierces(segment(0.7, 0.7, -1.0, 1.0), triangle), "it goes by");
        assert!(!pierces(segment(0.2, 0.2, 0.0, 1.0), triangle), "it touches");
    }
}
