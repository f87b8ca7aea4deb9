//! Warnings for bodies whose bounding boxes overlap although contact between them is not simulated, at the start and during a run.

use super::warning::{Warning, WarningCode};
use crate::body::Body;
use pliant_mesh::geometry::Vec3;
use std::collections::HashSet;

/// An axis-aligned box of a body, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extents {
    pub(super) min: Vec3,
    pub(super) max: Vec3,
}

impl Extents {
    /// The smallest box that contains `points` and `self`.
    fn with<'a>(self, points: impl Iterator<Item = &'a Vec3>) -> Self {
        points.fold(self, |all, p| Self { min: all.min.inf(p), max: all.max.sup(p) })
    }

    /// Whether the interiors of two boxes intersect.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|i| self.min[i].max(other.min[i]) < self.max[i].min(other.max[i]))
    }
}

/// A body of the scene, as tracked by [`OverlapDetection`].
pub(super) struct Extended {
    pub(super) name: String,
    /// Location in the scene.
    pub(super) place: String,
    /// Index among the moving bodies; `None` if it does not move.
    pub(super) moving: Option<usize>,
    /// Bounding box of the rest shape, m.
    pub(super) rest: Extents,
    /// Bounding box at the last test, m.
    pub(super) extents: Extents,
    /// Bounding box at the test before the last one, m.
    pub(super) before: Extents,
}

/// The present bounding box of a body: its box at rest, with each face displaced like the outermost nodes. The box of the nodes of a lattice would be too
/// large, because cells extend beyond the surface.
fn moved_extents(body: &Body, rest: Extents) -> Extents {
    let (x, at_rest) = (&body.system.nodes.x, &body.system.nodes.rest);
    let (Some(now), Some(before)) = (x.first(), at_rest.first()) else { return rest };
    let now = Extents { min: *now, max: *now }.with(x.iter());
    let before = Extents { min: *before, max: *before }.with(at_rest.iter());
    let moved = Extents { min: rest.min + now.min - before.min, max: rest.max + now.max - before.max };
    // Outside of a local region the body is at rest.
    if body.discretization.is_whole() { moved } else { rest.with([moved.min, moved.max].iter()) }
}

/// Why two bodies do not meet.
const WHY: &str = "not both have `meets = true`";

/// Number of steps between tests of the boxes; the boxes are swept over that interval.
const TEST_INTERVAL: u64 = 16;

/// Detection of bodies whose bounding boxes begin to overlap.
#[derive(Default)]
pub(super) struct OverlapDetection {
    bodies: Vec<Extended>,
    /// Pairs that need no more tests: handled elsewhere, or already warned of; the lower index first.
    known: HashSet<[usize; 2]>,
    pub(super) warnings: Vec<Warning>,
    /// Buffer of [`overlapping_pairs`].
    swept: Vec<(Extents, usize)>,
}

/// The pairs of boxes that overlap, the lower index first, in ascending order of the higher one: boxes are sorted along the axis
/// on which they are spread most, and each is compared with those that begin before it ends. The numbers of `boxes` are their indices.
fn overlapping_pairs(boxes: &mut [(Extents, usize)]) -> Vec<[usize; 2]> {
    let Some((first, _)) = boxes.first() else { return Vec::new() };
    let all = boxes.iter().fold(*first, |all, (b, _)| Extents { min: all.min.inf(&b.min), max: all.max.sup(&b.min) });
    let axis = (all.max - all.min).imax();
    boxes.sort_unstable_by(|(a, i), (b, j)| a.min[axis].total_cmp(&b.min[axis]).then(i.cmp(j)));
    let mut pairs = Vec::new();
    for (at, (a, i)) in boxes.iter().enumerate() {
        let near = boxes[at + 1..].iter().take_while(|(b, _)| b.min[axis] < a.max[axis]);
        pairs.extend(near.filter(|(b, _)| a.overlaps(b)).map(|(_, j)| [*i.min(j), *i.max(j)]));
    }
    pairs.sort_unstable_by_key(|[i, j]| [*j, *i]);
    pairs
}

impl OverlapDetection {
    /// Starts with the bodies of a scene, in its order, and returns the warnings for those that overlap. Pairs of moving bodies in `handled` are left
    /// out, lower index first: they meet, or a warning says that they do not. So are those for which `is_tied` holds.
    pub(super) fn new(
        bodies: Vec<Extended>,
        handled: impl Iterator<Item = [usize; 2]>,
        is_tied: impl Fn([usize; 2]) -> bool,
    ) -> (Self, Vec<Warning>) {
        let moving: Vec<usize> = (0..bodies.len()).filter(|i| bodies[*i].moving.is_some()).collect();
        let known = handled.map(|pair| pair.map(|index| moving[index])).collect();
        let mut detection = Self { bodies, known, ..Self::default() };
        let at_start = detection.test(None, is_tied);
        (detection, at_start)
    }

    /// Warnings for pairs whose swept boxes overlap now for the first time, except for moving bodies that are tied: at the time `time` (s) of a run, or
    /// before its first step.
    fn test(&mut self, time: Option<f64>, is_tied: impl Fn([usize; 2]) -> bool) -> Vec<Warning> {
        let Self { bodies, known, swept, .. } = self;
        swept.clear();
        swept.extend(
            bodies
                .iter()
                .enumerate()
                .map(|(i, Extended { extents, before, .. })| (extents.with([before.min, before.max].iter()), i)),
        );
        let mut found = Vec::new();
        for pair in overlapping_pairs(swept) {
            let [a, b] = pair.map(|index| &bodies[index]);
            let is_exempt = matches!([a.moving, b.moving], [Some(a), Some(b)] if is_tied([a, b]));
            if is_exempt || !known.insert(pair) {
                continue;
            }
            let (code, message) = match time {
                None => (
                    WarningCode::BodiesOverlap,
                    format!(
                        "the boxes of bodies `{}` and `{}` overlap at the start, and {WHY}, so they pass through each other; let both meet (`meets = true`), move one \
                         of them, or make them one model",
                        a.name, b.name
                    ),
                ),
                Some(time) => (
                    WarningCode::BodiesMeet,
                    format!(
                        "the boxes of bodies `{}` and `{}` came together by {time:.4} s, and {WHY}, so they pass through each other; let both meet (`meets = true`)",
                        a.name, b.name
                    ),
                ),
            };
            found.push(Warning { code, place: b.place.clone(), message });
        }
        found
    }

    /// Tests whether boxes have begun to overlap since the last test, after step number `steps`, at `time` (s).
    pub(super) fn update(&mut self, steps: u64, time: f64, bodies: &[Body], is_tied: impl Fn([usize; 2]) -> bool) {
        let count = self.bodies.len();
        if count < 2 || !steps.is_multiple_of(TEST_INTERVAL) || self.known.len() == count * (count - 1) / 2 {
            return;
        }
        for extended in &mut self.bodies {
            extended.before = extended.extents;
            let Some(body) = extended.moving.and_then(|index| bodies.get(index)) else { continue };
            extended.extents = moved_extents(body, extended.rest);
        }
        let found = self.test(Some(time), is_tied);
        self.warnings.extend(found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(name: &str, at: f64) -> Extended {
        let extents = Extents { min: Vec3::repeat(at), max: Vec3::repeat(at + 1.0) };
        Extended { name: name.into(), place: name.into(), moving: None, rest: extents, extents, before: extents }
    }

    #[test]
    fn touching_boxes_do_not_overlap_and_a_pair_is_reported_once() {
        let (mut detection, warnings) =
            OverlapDetection::new(vec![body("a", 0.0), body("b", 1.0), body("c", 1.5)], std::iter::empty(), |_| false);
        assert_eq!(warnings.len(), 1, "b and c alone: {warnings:?}");
        // It sweeps over both others between two tests.
        detection.bodies[0].extents = body("a", 9.0).extents;
        assert_eq!(detection.test(Some(0.1), |_| false).len(), 2);
        assert!(detection.test(Some(0.2), |_| false).is_empty());
    }

    #[test]
    fn pairs_are_those_that_comparing_all_boxes_finds() {
        let mut random = pliant_mesh::testing::Random(7);
        for _ in 0..50 {
            let mut point = |scale: f64| Vec3::from_fn(|i, _| scale * [1.0, 4.0, 0.5][i] * random.unit());
            let boxes: Vec<(Extents, usize)> = (0..60)
                .map(|i| {
                    let min = point(1.0);
                    (Extents { min, max: min + point(0.3) }, i)
                })
                .collect();
            let all = (0..60).flat_map(|j| (0..j).map(move |i| [i, j]));
            let expected: Vec<_> = all.filter(|[i, j]| boxes[*i].0.overlaps(&boxes[*j].0)).collect();
            assert!(expected.len() > 10, "{}", expected.len());
            assert_eq!(overlapping_pairs(&mut boxes.clone()), expected);
        }
    }

    #[test]
    fn tied_bodies_are_not_warned_of_while_they_are_tied() {
        let moving = |name: &str, at: f64, index: usize| Extended { moving: Some(index), ..body(name, at) };
        let bodies = vec![body("stands", 7.0), moving("a", 0.0, 0), moving("b", 0.5, 1), moving("c", 3.0, 2)];
        let (mut detection, warnings) = OverlapDetection::new(bodies, [[1, 2]].into_iter(), |pair| pair == [0, 1]);
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(detection.test(Some(0.1), |_| false).len(), 1, "a and b, once their ties are cut");
    }
}
