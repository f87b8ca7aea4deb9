//! Live stitching of two bodies: what a stroke of the edit `stitch` ties, or draws together first.

use super::ties::{CLOSING_TIME, Stroke};
use super::{EventKind, Session};
use crate::body::{Body, LatticeError};
use crate::contact::{SearchBall, StitchCandidate, StitchSearch};
use crate::edit::StitchRequest;
use pliant_solver::Vec3;
use std::sync::Arc;

impl Session {
    /// Lets go of what the stroke of a tool was drawing together.
    pub(super) fn end_drawing(&mut self, tool: usize) {
        self.ties.drop_drawn(tool);
    }

    /// Ties what a stroke of a tool asks for: points of the body that it touches to those of others that face them.
    pub(super) fn stitch_to_others(&mut self, tool: usize, request: StitchRequest, time: f64) {
        let StitchRequest { at, radius } = request;
        let first = at.body as usize;
        let Ok(centre) = self.bodies[first].embed_point(at.rest).map(|point| point.now) else { return };
        for second in (0..self.bodies.len()).filter(|index| *index != first) {
            let edges = [first, second].map(|index| self.bodies[index].discretization.edge());
            let spacing = self.tie_spacing([first, second]);
            let search = StitchSearch { ball: Some(SearchBall { centre, radius }), reach: radius, spacing };
            let found = match self.find_stitches([first, second], search) {
                Ok(found) if found.is_empty() => continue,
                Ok(found) => found,
                Err(error) => {
                    self.events.add(EventKind::Message, time, || error.to_string());
                    continue;
                }
            };
            if let Some(why) = self.refuses_ties([first, second]) {
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
        let mut body_contacts = std::mem::take(&mut self.body_contacts);
        body_contacts.reserve(self.bodies.len());
        let found = body_contacts.collisions.stitch_candidates(bodies, &mut self.bodies, search);
        self.body_contacts = body_contacts;
        found
    }

    /// Ties those candidates that are at least `spacing` (m) from all ties of the two bodies.
    fn tie_candidates(&mut self, stroke: Stroke, pair: [usize; 2], found: &[StitchCandidate], spacing: f64, time: f64) {
        let numbers = pair.map(|index| self.bodies[index].number);
        let mut taken: Vec<[Vec3; 2]> = Vec::new();
        let list = Arc::clone(&self.ties.list);
        for tie in list.iter() {
            let is_same = tie.bodies == numbers;
            if is_same || tie.bodies == [numbers[1], numbers[0]] {
                let points = if is_same { tie.points } else { [tie.points[1], tie.points[0]] };
                let place = |side: usize| {
                    self.body_contacts.collisions.place_of(
                        pair[side],
                        points[side],
                        &self.bodies[pair[side]].system.nodes.x,
                    )
                };
                taken.extend(place(0).zip(place(1)).map(|(a, b)| [a, b]));
            }
        }
        let is_free = |candidate: &&StitchCandidate| {
            let is_near = |other: &[Vec3; 2]| (0..2).any(|k| (other[k] - candidate.positions[k]).norm() < spacing);
            !taken.iter().any(is_near)
        };
        for candidate in found.iter().filter(is_free) {
            let gap = candidate.gap();
            let is_far = gap.norm() > stroke.near;
            let drawn_by = is_far.then_some(stroke);
            self.ties.push(numbers, candidate.points, gap, time + CLOSING_TIME, drawn_by);
            self.tools[stroke.tool].has_tied |= !is_far;
        }
    }
}
