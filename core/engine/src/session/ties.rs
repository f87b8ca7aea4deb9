//! Ties: points of two bodies that are stitched together. They are rows of the implicit solve of contact, so each body yields with its own matrix, and last
//! until they are undone or a blade cuts the triangle that one of their points is on.

use super::interactions::Interactions;
use super::{EventKind, Session};
use crate::body::Body;
use crate::contact::{BodyCollisions, TiePoint, TieRow};
use pliant_solver::{Scheme, StepTime, Vec3};
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
    bodies: [u32; 2],
    points: [TiePoint; 2],
    /// Displacement of the first point from the second at the end of the last step, m.
    gap: Vec3,
    /// Time at which there is none, s.
    closed_at: f64,
    /// The stroke that still draws the points together; `None` for a tie that holds.
    drawn_by: Option<Stroke>,
}

impl Tie {
    /// Indices of its bodies; `None` where one is not among those of the session at present.
    fn places(&self, bodies: &[Body]) -> Option<[usize; 2]> {
        let [a, b] = self.bodies.map(|number| bodies.iter().position(|body| body.number == number));
        Some([a?, b?])
    }
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
    list: Arc<Vec<Tie>>,
    /// Number of the next tie.
    next: u32,
}

impl Ties {
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

    /// Number of ties, also of those that are still drawn together.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// Finds the pairs of bodies that are stitched, each once, lower index first, in ascending order.
    pub fn find_pairs(&self, bodies: &[Body], pairs: &mut Vec<[usize; 2]>) {
        pairs.clear();
        for tie in self.list.iter() {
            let Some([a, b]) = tie.places(bodies) else { continue };
            let pair = [a.min(b), a.max(b)];
            if let Err(place) = pairs.binary_search(&pair) {
                pairs.insert(place, pair);
            }
        }
    }

    /// Points of the ties of two bodies with these numbers, the point of the first body first.
    pub fn points_between(&self, numbers: [u32; 2]) -> impl Iterator<Item = [TiePoint; 2]> + '_ {
        self.list.iter().filter_map(move |tie| match tie.bodies {
            bodies if bodies == numbers => Some(tie.points),
            [a, b] if [b, a] == numbers => Some([tie.points[1], tie.points[0]]),
            _ => None,
        })
    }

    /// Present distance of the points of each tie, m, of those whose points are on simulated parts.
    pub fn gaps(&self, collisions: &mut BodyCollisions, bodies: &mut [Body]) -> Vec<f64> {
        let gap = |tie: &Tie| collisions.gap(tie.places(bodies)?, tie.points, bodies).ok()?;
        self.list.iter().filter_map(gap).map(|gap| gap.norm()).collect()
    }

    /// Removes ties that a blade has cut. Returns how many.
    pub fn remove_cut(&mut self, bodies: &[Body]) -> usize {
        let is_whole = |tie: &Tie| {
            tie.bodies.iter().zip(&tie.points).all(|(number, point)| {
                bodies.iter().find(|body| body.number == *number).is_some_and(|body| point.is_on(&body.model))
            })
        };
        if self.list.iter().all(is_whole) { 0 } else { self.retain(is_whole) }
    }

    /// Adds the ties to the solve of a step. `members` gives the places of two bodies among those that are solved for, `None` where nothing of the two moves;
    /// `max_force` the largest force of a tool, N. Returns whether there are any.
    pub fn add_rows(
        &self,
        collisions: &mut BodyCollisions,
        bodies: &[Body],
        time: StepTime,
        members: impl Fn([usize; 2]) -> Option<[usize; 2]>,
        max_force: impl Fn(usize) -> f64,
    ) -> bool {
        let mut any = false;
        for tie in self.list.iter() {
            let Some(members) = tie.places(bodies).and_then(&members) else { continue };
            // The pairs of a stroke are drawn together by the same force each: all of them are as strong as its tool may be.
            let most = tie.drawn_by.map_or(f64::INFINITY, |Stroke { tool, .. }| {
                max_force(tool) / self.drawn_by(tool).max(1) as f64 * time.dt
            });
            let share = tie.drawn_by.map(|_| 1.0 - time.dt / CLOSING_TIME.max(time.dt));
            let (number, points, gap) = (tie.number, tie.points, left_gap(tie, time));
            collisions.add_tie(TieRow { number, members, points, share, gap, most });
            any = true;
        }
        any
    }

    /// Number of ties that a tool still draws together.
    fn drawn_by(&self, tool: usize) -> usize {
        self.list.iter().filter(|tie| tie.drawn_by.is_some_and(|stroke| stroke.tool == tool)).count()
    }

    /// Records what a step has done: ties are shorter, and points that have come near are tied. `on_tied` is called with the tool of each of these.
    pub fn advance(
        &mut self,
        collisions: &mut BodyCollisions,
        bodies: &mut [Body],
        time: StepTime,
        mut on_tied: impl FnMut(usize),
    ) {
        if self.list.iter().all(|tie| tie.drawn_by.is_none() && tie.gap == Vec3::zeros()) {
            return;
        }
        for tie in Arc::make_mut(&mut self.list) {
            let Some(Stroke { tool, near }) = tie.drawn_by else {
                tie.gap = left_gap(tie, time);
                continue;
            };
            let Some(places) = tie.places(bodies) else { continue };
            let Ok(Some(gap)) = collisions.gap(places, tie.points, bodies) else { continue };
            tie.gap = gap;
            if gap.norm() <= near {
                (tie.drawn_by, tie.closed_at) = (None, time.start + time.dt + CLOSING_TIME);
                on_tied(tool);
            }
        }
    }
}

impl Session {
    /// Number of ties between points of two bodies, also those that are still drawn together.
    pub fn tie_count(&self) -> usize {
        self.interactions.ties.count()
    }

    /// Distance of the points of each tie, m, in the order in which they were made; of those whose points are on simulated parts.
    pub fn tie_gaps(&mut self) -> Vec<f64> {
        let Interactions { ties, body_contacts, .. } = &mut self.interactions;
        ties.gaps(body_contacts.collisions(self.bodies.len()), &mut self.bodies)
    }

    /// Opens ties that a blade has cut, before bodies move.
    pub(super) fn open_cut_ties(&mut self, time: f64) {
        let opened = self.interactions.ties.remove_cut(&self.bodies);
        self.events.add_many(EventKind::StitchOpened, opened as u64, time, || {
            format!("{opened} ties between bodies are gone with the surface that they were on")
        });
    }
}

/// Least distance of ties of two bodies from each other, m.
pub(super) fn tie_spacing(bodies: &[Body], pair: [usize; 2]) -> f64 {
    let [a, b] = pair.map(|index| bodies[index].discretization.edge());
    SPACING * a.max(b)
}

/// Why two bodies cannot be stitched together under a scheme; `None` where they can.
pub(super) fn tie_refusal(scheme: Scheme, bodies: &[Body], pair: [usize; 2]) -> Option<String> {
    let names = pair.map(|index| bodies[index].name.as_str());
    let not = format!("bodies `{}` and `{}` are not stitched together", names[0], names[1]);
    if !scheme.is_implicit() || !scheme.has_inertia() {
        let name = scheme.name();
        return Some(format!(
            "{not}: the integrator is `{name}`; allowed is an implicit one with inertia, as `backward-euler`"
        ));
    }
    let local = pair.iter().find(|index| !bodies[**index].discretization.is_whole())?;
    let name = &bodies[*local].name;
    Some(format!("{not}: of `{name}` only cells around tools move; allowed is `grid = {{ region = \"whole\" }}`"))
}

/// Displacement of the points of a tie at the end of a step, m.
fn left_gap(tie: &Tie, time: StepTime) -> Vec3 {
    let left = tie.closed_at - time.start;
    let share = if left > 1.5 * time.dt { 1.0 - time.dt / left } else { 0.0 };
    share * tie.gap
}
