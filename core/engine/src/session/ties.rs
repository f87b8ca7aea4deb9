//! Ties: points of two bodies that are stitched together. They are rows of the implicit solve of contact, so each body yields with its own matrix, and last
//! until they are undone or a blade cuts the triangle that one of their points is on.

use super::body_contacts::BodyContacts;
use super::{EventKind, Session};
use crate::body::Body;
use crate::contact::{TiePoint, TieRow};
use pliant_solver::{StepTime, Vec3};
use std::sync::Arc;

/// Time in which a tie that begins with points apart brings them together, s.
pub(super) const CLOSING_TIME: f64 = 0.1;
/// Least distance of ties from each other, in edges of the coarser of the two bodies: with more than one for each node, ties would say the same twice.
const SPACING: f64 = 0.9;

/// A tie of points of two bodies.
#[derive(Clone, Debug)]
pub(super) struct Tie {
    number: u32,
    /// Numbers of the bodies in the session.
    pub bodies: [u32; 2],
    pub points: [TiePoint; 2],
    /// Displacement of the first point from the second at the end of the last step, m.
    gap: Vec3,
    /// Time at which there is none, s.
    closed_at: f64,
    /// The stroke that still draws the points together; `None` for a tie that holds.
    drawn_by: Option<Stroke>,
}

/// A stroke that draws points together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    /// Index of its tool.
    pub tool: usize,
    /// Distance from which on the points are tied, m.
    pub near: f64,
}

/// Ties of a session.
#[derive(Clone, Default)]
pub(super) struct Ties {
    pub list: Arc<Vec<Tie>>,
    /// Number of the next tie.
    next: u32,
}

impl Ties {
    /// Whether there are no ties.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The ties that hold, without those that a tool is still drawing together, for undo and snapshots.
    pub fn kept(&self) -> Self {
        match self.list.iter().any(|tie| tie.drawn_by.is_some()) {
            true => Self {
                list: Arc::new(self.list.iter().filter(|tie| tie.drawn_by.is_none()).cloned().collect()),
                next: self.next,
            },
            false => self.clone(),
        }
    }

    /// Adds a tie whose points have the displacement `gap` (m), which vanishes at `closed_at` (s).
    pub fn add(&mut self, bodies: [u32; 2], points: [TiePoint; 2], gap: Vec3, closed_at: f64) {
        self.push(bodies, points, gap, closed_at, None);
    }

    /// The same, of points that a stroke still draws together if one is given.
    pub fn push(
        &mut self,
        bodies: [u32; 2],
        points: [TiePoint; 2],
        gap: Vec3,
        closed_at: f64,
        drawn_by: Option<Stroke>,
    ) {
        let tie = Tie { number: self.next, bodies, points, gap, closed_at, drawn_by };
        Arc::make_mut(&mut self.list).push(tie);
        self.next += 1;
    }

    /// Removes the ties that a tool still draws. Returns whether there were any.
    pub fn drop_drawn(&mut self, tool: usize) -> bool {
        let is_drawn = |tie: &Tie| tie.drawn_by.is_some_and(|stroke| stroke.tool == tool);
        let any = self.list.iter().any(is_drawn);
        if any {
            Arc::make_mut(&mut self.list).retain(|tie| !is_drawn(tie));
        }
        any
    }

    /// Removes ties that a test does not keep. Returns how many.
    fn retain(&mut self, keeps: impl FnMut(&Tie) -> bool) -> usize {
        let before = self.list.len();
        Arc::make_mut(&mut self.list).retain(keeps);
        before - self.list.len()
    }

    /// The body number `whole` is now `parts`: its ties belong to the part that has their points.
    pub fn divide(&mut self, whole: u32, parts: &[Body]) {
        if !self.list.iter().any(|tie| tie.bodies.contains(&whole)) {
            return;
        }
        for tie in Arc::make_mut(&mut self.list) {
            for side in 0..2 {
                let holder = || parts.iter().find(|part| tie.points[side].is_on(&part.model));
                if tie.bodies[side] == whole
                    && let Some(part) = holder()
                {
                    tie.bodies[side] = part.number;
                }
            }
        }
        // One that no part has was cut through.
        self.retain(|tie| !tie.bodies.contains(&whole));
    }
}

impl Session {
    /// Number of ties between points of two bodies, also those that are still drawn together.
    pub fn tie_count(&self) -> usize {
        self.ties.list.len()
    }

    /// Distance of the points of each tie, m, in the order in which they were made; of those whose points are on simulated parts.
    pub fn tie_gaps(&mut self) -> Vec<f64> {
        let mut body_contacts = std::mem::take(&mut self.body_contacts);
        body_contacts.reserve(self.bodies.len());
        let list = Arc::clone(&self.ties.list);
        let gap = |tie: &Tie| {
            let bodies = self.places_of(tie)?;
            body_contacts.collisions.gap(bodies, tie.points, &mut self.bodies).ok()?
        };
        let gaps = list.iter().filter_map(gap).map(|gap| gap.norm()).collect();
        self.body_contacts = body_contacts;
        gaps
    }

    /// Indices of the bodies of a tie.
    pub(super) fn places_of(&self, tie: &Tie) -> Option<[usize; 2]> {
        let [a, b] = tie.bodies.map(|number| self.bodies.iter().position(|body| body.number == number));
        Some([a?, b?])
    }

    /// The pairs of bodies that are stitched, each once, lower index first, in ascending order.
    pub(super) fn find_tied(&self, tied: &mut Vec<[usize; 2]>) {
        tied.clear();
        for tie in self.ties.list.iter() {
            let Some([a, b]) = self.places_of(tie) else { continue };
            let pair = [a.min(b), a.max(b)];
            if let Err(place) = tied.binary_search(&pair) {
                tied.insert(place, pair);
            }
        }
    }

    /// Opens ties that a blade has cut, before bodies move.
    pub(super) fn open_cut_ties(&mut self, time: f64) {
        if self.ties.is_empty() {
            return;
        }
        let bodies = &self.bodies;
        let is_whole = |tie: &Tie| {
            tie.bodies.iter().zip(&tie.points).all(|(number, point)| {
                bodies.iter().find(|body| body.number == *number).is_some_and(|body| point.is_on(&body.model))
            })
        };
        if self.ties.list.iter().all(is_whole) {
            return;
        }
        let opened = self.ties.retain(is_whole);
        self.events.add_many(EventKind::StitchOpened, opened as u64, time, || {
            format!("{opened} ties between bodies are gone with the surface that they were on")
        });
    }

    /// Adds the ties between members to the solve of a step. `place` gives the place of a body among them.
    pub(super) fn add_tie_rows(
        &self,
        body_contacts: &mut BodyContacts,
        place: impl Fn(usize) -> Option<usize>,
        time: StepTime,
    ) -> bool {
        let mut any = false;
        for tie in self.ties.list.iter() {
            let Some([i, j]) = self.places_of(tie) else { continue };
            let (Some(a), Some(b), false) = (place(i), place(j), self.stands(i) && self.stands(j)) else { continue };
            let most = tie.drawn_by.map_or(f64::INFINITY, |stroke| self.draws_with(stroke.tool) * time.dt);
            let share = tie.drawn_by.map(|_| 1.0 - time.dt / CLOSING_TIME.max(time.dt));
            let (number, points, gap) = (tie.number, tie.points, left_gap(tie, time));
            body_contacts.collisions.add_tie(TieRow { number, members: [a, b], points, share, gap, most });
            any = true;
        }
        any
    }

    /// Force (N) with which a stroke draws each of its pairs together: all of them are as strong as its tool may be.
    fn draws_with(&self, tool: usize) -> f64 {
        let drawn = self.ties.list.iter().filter(|tie| tie.drawn_by.is_some_and(|stroke| stroke.tool == tool)).count();
        self.tools[tool].tool.coupling.max_force / drawn.max(1) as f64
    }

    /// Records what a step has done to ties: they are shorter, and points that have come near are tied.
    pub(super) fn advance_ties(&mut self, body_contacts: &mut BodyContacts, time: StepTime) {
        if self.ties.list.iter().all(|tie| tie.drawn_by.is_none() && tie.gap == Vec3::zeros()) {
            return;
        }
        let mut list = std::mem::take(&mut self.ties.list);
        for tie in Arc::make_mut(&mut list) {
            let Some(Stroke { tool, near }) = tie.drawn_by else {
                tie.gap = left_gap(tie, time);
                continue;
            };
            let Some(bodies) = self.places_of(tie) else { continue };
            let Ok(Some(gap)) = body_contacts.collisions.gap(bodies, tie.points, &mut self.bodies) else { continue };
            tie.gap = gap;
            if gap.norm() <= near {
                (tie.drawn_by, tie.closed_at) = (None, time.start + time.dt + CLOSING_TIME);
                self.tools[tool].has_tied = true;
            }
        }
        self.ties.list = list;
    }

    /// Least distance of ties of two bodies from each other, m.
    pub(super) fn tie_spacing(&self, pair: [usize; 2]) -> f64 {
        let [a, b] = pair.map(|index| self.bodies[index].discretization.edge());
        SPACING * a.max(b)
    }

    /// Why two bodies cannot be stitched together; `None` where they can.
    pub(super) fn refuses_ties(&self, pair: [usize; 2]) -> Option<String> {
        let names = pair.map(|index| self.bodies[index].name.as_str());
        let not = format!("bodies `{}` and `{}` are not stitched together", names[0], names[1]);
        let scheme = self.limits.scheme;
        if !scheme.is_implicit() || !scheme.has_inertia() {
            let name = scheme.name();
            return Some(format!(
                "{not}: the integrator is `{name}`; allowed is an implicit one with inertia, as `backward-euler`"
            ));
        }
        let local = pair.iter().find(|index| !self.bodies[**index].discretization.is_whole())?;
        let name = &self.bodies[*local].name;
        Some(format!("{not}: of `{name}` only cells around tools move; allowed is `grid = {{ region = \"whole\" }}`"))
    }
}

/// Displacement of the points of a tie at the end of a step, m.
fn left_gap(tie: &Tie, time: StepTime) -> Vec3 {
    let left = tie.closed_at - time.start;
    let share = if left > 1.5 * time.dt { 1.0 - time.dt / left } else { 0.0 };
    share * tie.gap
}
