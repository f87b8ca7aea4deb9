//! Live stitching of two bodies: what a stroke of the edit `stitch` ties, or draws together first.

use super::interactions::Interactions;
use super::ties::{CLOSING_TIME, Stroke, tie_refusal, tie_spacing};
use super::{EventKind, Session};
use crate::body::{Body, LatticeError};
use crate::contact::{SearchBall, StitchCandidate, StitchSearch, TiePoint};
use crate::edit::StitchRequest;
use pliant_solver::Vec3;

impl Session {
    /// Ties what a stroke of a tool asks for: points of the body that it touches to those of others that face them.
    pub(super) fn stitch_to_others(&mut self, tool: usize, request: StitchRequest, time: f64) {
        let StitchRequest { at, radius } = request;
        let first = at.body as usize;
        let Ok(centre) = self.bodies[first].embed_point(at.rest).map(|point| point.now) else { return };
        for second in (0..self.bodies.len()).filter(|index| *index != first) {
            let edges = [first, second].map(|index| self.bodies[index].discretization.edge());
            let spacing = tie_spacing(&self.bodies, [first, second]);
            let search = StitchSearch { ball: Some(SearchBall { centre, radius }), reach: radius, spacing };
            let found = match self.find_stitches([first, second], search) {
                Ok(found) if found.is_empty() => continue,
                Ok(found) => found,
                Err(error) => {
                    self.events.add(EventKind::Message, time, || error.to_string());
                    continue;
                }
            };
            if let Some(why) = tie_refusal(self.motion.limits.scheme, &self.bodies, [first, second]) {
                if !std::mem::replace(&mut self.tools[tool].is_stitch_refused, true) {
                    let name = &self.tools[tool].tool.name;
                    self.events.add(EventKind::StitchRefused, time, || format!("tool `{name}`: {why}"));
                }
                continue;
            }
            let stroke = Stroke { tool, near: Body::join_distance(edges[0].min(edges[1])) };
            self.tie_candidates(stroke, [first, second], &found, spacing, time);
        }
    }

    /// Points of two bodies that a stitch may tie.
    pub(super) fn find_stitches(
        &mut self,
        bodies: [usize; 2],
        search: StitchSearch,
    ) -> Result<Vec<StitchCandidate>, LatticeError> {
        let collisions = self.interactions.body_contacts.collisions(self.bodies.len());
        collisions.stitch_candidates(bodies, &mut self.bodies, search)
    }

    /// Ties those candidates that are at least `spacing` (m) from all ties of the two bodies.
    fn tie_candidates(&mut self, stroke: Stroke, pair: [usize; 2], found: &[StitchCandidate], spacing: f64, time: f64) {
        let numbers = pair.map(|index| self.bodies[index].number);
        let Interactions { ties, body_contacts, .. } = &mut self.interactions;
        let collisions = body_contacts.collisions(self.bodies.len());
        let positions = |points: [TiePoint; 2]| {
            let place = |side: usize| {
                let body = pair[side];
                collisions.place_of(body, points[side], &self.bodies[body].system.nodes.x)
            };
            place(0).zip(place(1)).map(|(a, b)| [a, b])
        };
        let taken: Vec<[Vec3; 2]> = ties.points_between(numbers).filter_map(positions).collect();
        let is_free = |candidate: &&StitchCandidate| {
            let is_near = |other: &[Vec3; 2]| (0..2).any(|k| (other[k] - candidate.positions[k]).norm() < spacing);
            !taken.iter().any(is_near)
        };
        for candidate in found.iter().filter(is_free) {
            let gap = candidate.gap();
            let is_far = gap.norm() > stroke.near;
            let drawn_by = is_far.then_some(stroke);
            ties.push(numbers, candidate.points, gap, time + CLOSING_TIME, drawn_by);
            self.tools[stroke.tool].has_tied |= !is_far;
        }
    }
}
