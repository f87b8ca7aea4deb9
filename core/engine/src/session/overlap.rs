//! Warnings for bodies whose bounding boxes overlap although contact between them is not simulated, at the start and during a run.

use super::Session;
use super::warning::{Warning, WarningCode};
use crate::body::Body;
use pliant_mesh::geometry::Vec3;

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
    /// Pairs that need no more tests: handled elsewhere, or already warned of.
    known: Vec<[usize; 2]>,
    pub(super) warnings: Vec<Warning>,
}

impl OverlapDetection {
    /// Starts with the bodies of a scene, in its order, and returns the warnings for those that overlap. Two moving bodies for which `is_handled` holds are left out:
    /// they meet, or a warning says that they do not.
    pub(super) fn new(bodies: Vec<Extended>, is_handled: impl Fn(usize, usize) -> bool) -> (Self, Vec<Warning>) {
        let mut known = Vec::new();
        for (j, b) in bodies.iter().enumerate() {
            let meets = |a: &Extended| matches!((a.moving, b.moving), (Some(a), Some(b)) if is_handled(a, b));
            known.extend((0..j).filter(|i| meets(&bodies[*i])).map(|i| [i, j]));
        }
        let mut detection = Self { bodies, known, ..Self::default() };
        let at_start = detection.test(None);
        (detection, at_start)
    }

    /// Warnings for pairs whose swept boxes overlap now for the first time: at the time `time` (s) of a run, or before its first step.
    fn test(&mut self, time: Option<f64>) -> Vec<Warning> {
        let swept = |i: usize| {
            let Extended { extents, before, .. } = &self.bodies[i];
            extents.with([before.min, before.max].iter())
        };
        let mut found = Vec::new();
        for j in 0..self.bodies.len() {
            for i in 0..j {
                if self.known.contains(&[i, j]) || !swept(i).overlaps(&swept(j)) {
                    continue;
                }
                self.known.push([i, j]);
                let [a, b] = [&self.bodies[i], &self.bodies[j]];
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
        }
        found
    }
}

impl Session {
    /// Tests whether boxes have begun to overlap since the last test.
    pub(super) fn detect_overlaps(&mut self) {
        let count = self.warnings.overlaps.bodies.len();
        if count < 2
            || !self.clock.steps.is_multiple_of(TEST_INTERVAL)
            || self.warnings.overlaps.known.len() == count * (count - 1) / 2
        {
            return;
        }
        for extended in &mut self.warnings.overlaps.bodies {
            extended.before = extended.extents;
            let Some(body) = extended.moving.and_then(|index| self.bodies.get(index)) else { continue };
            extended.extents = moved_extents(body, extended.rest);
        }
        let time = self.time();
        let found = self.warnings.overlaps.test(Some(time));
        self.warnings.overlaps.warnings.extend(found);
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
            OverlapDetection::new(vec![body("a", 0.0), body("b", 1.0), body("c", 1.5)], |_, _| false);
        assert_eq!(warnings.len(), 1, "b and c alone: {warnings:?}");
        // It sweeps over both others between two tests.
        detection.bodies[0].extents = body("a", 9.0).extents;
        assert_eq!(detection.test(Some(0.1)).len(), 2);
        assert!(detection.test(Some(0.2)).is_empty());
    }
}
