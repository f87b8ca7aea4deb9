//! Contact of bodies with each other in a session: which are near or stitched together, and the stage after they have moved.

use super::body_responses::{BodyResponses, ResponseState};
use super::motion::Motion;
use super::ties::Ties;
use super::{EventKind, Session, SessionError};
use crate::body::{Body, LatticeError};
use crate::contact::{BodyCollisions, CollisionReport, CollisionSettings};
use crate::plan::Plan;
use pliant_solver::{StepTime, Vec3};
use std::time::Instant;

/// Two bodies that may meet, or one that meets itself.
#[derive(Clone)]
struct CollisionPair {
    bodies: [usize; 2],
    friction: [f64; 2],
    /// What the boxes of the two can still close before they overlap, m.
    slack: f64,
    /// Whether the two may touch in this step.
    is_near: bool,
}

/// What a session knows about the contact of its bodies with each other.
#[derive(Default)]
pub(super) struct BodyContacts {
    pairs: Vec<CollisionPair>,
    /// The pairs of the bodies of the scene, once one of them has been split.
    of_scene: Option<Vec<CollisionPair>>,
    collisions: BodyCollisions,
    /// Whether each body is near another in this step, or stitched to one; empty without pairs and ties.
    near: Vec<bool>,
    /// Wall-clock time of the stage in the last step, s.
    seconds: f64,
    /// What contact did in the last step.
    report: CollisionReport,
    responses: Vec<ResponseState>,
    /// Forces of contact on the nodes of each body in the last step, N (n x 3), or empty for none: the next step begins with them, so that what holds the
    /// body feels them.
    forces: Vec<Vec<Vec3>>,
    /// Whether each body has moved under them.
    is_loaded: Vec<bool>,
    /// Pairs of bodies that are stitched together, lower index first; they do not meet.
    tied: Vec<[usize; 2]>,
    /// Buffer of [`Session::resolve_body_contact`].
    members: Vec<usize>,
}

impl BodyContacts {
    /// The pairs of a plan.
    pub(super) fn new(plan: &Plan, bodies: &[Body]) -> Self {
        let moving =
            plan.collisions.iter().zip(&plan.moving).filter(|(_, moves)| **moves).map(|(settings, _)| *settings);
        let of: Vec<CollisionSettings> = moving.collect();
        let is_linear = |i: usize| bodies[i].discretization.lattice().is_none_or(|l| !l.source.is_nonlinear());
        let mut pairs = Vec::new();
        let meeting: Vec<usize> = (0..of.len()).filter(|i| of[*i].meets || of[*i].meets_itself).collect();
        for (at, &j) in meeting.iter().enumerate() {
            for &i in &meeting[..=at] {
                let (a, b) = (of[i], of[j]);
                let meet = if i == j { a.meets_itself } else { a.meets && b.meets && is_linear(i) && is_linear(j) };
                if meet {
                    let friction = [0, 1].map(|k| a.friction[k].min(b.friction[k]));
                    pairs.push(CollisionPair { bodies: [i, j], friction, slack: 0.0, is_near: false });
                }
            }
        }
        let mut body_contacts = Self { pairs, ..Self::default() };
        if !body_contacts.pairs.is_empty() {
            body_contacts.reserve(of.len());
        }
        body_contacts
    }

    /// The collisions of this many bodies, with room for them.
    pub(super) fn collisions(&mut self, bodies: usize) -> &mut BodyCollisions {
        self.reserve(bodies);
        &mut self.collisions
    }

    /// Makes room for this many bodies, where contact has had nothing to do so far.
    fn reserve(&mut self, bodies: usize) {
        if self.near.len() != bodies {
            self.collisions = BodyCollisions::new(bodies);
            self.near = vec![false; bodies];
            (self.forces, self.is_loaded) = (vec![Vec::new(); bodies], vec![false; bodies]);
        }
    }

    /// Whether two bodies are stitched together, in this step; the lower index first.
    pub(super) fn is_tied(&self, bodies: [usize; 2]) -> bool {
        self.tied.binary_search(&bodies).is_ok()
    }

    /// Adapts to other bodies, of which each is a part of the body of the scene in `roots`, or that body. Parts meet what the whole meets, and not each other: they lie
    /// against each other where they were cut.
    pub(super) fn set_bodies(&mut self, roots: &[usize]) {
        let of_scene = self.of_scene.get_or_insert_with(|| self.pairs.clone());
        if of_scene.is_empty() && self.near.is_empty() {
            return;
        }
        let mut pairs = Vec::new();
        for (j, b) in roots.iter().enumerate() {
            for (i, a) in roots[..=j].iter().enumerate().filter(|(i, a)| *i == j || *a != b) {
                let same = of_scene.iter().find(|pair| pair.bodies == [*a.min(b), *a.max(b)]);
                pairs.extend(same.map(|pair| CollisionPair { bodies: [i, j], slack: 0.0, is_near: false, ..*pair }));
            }
        }
        (self.pairs, self.near) = (pairs, Vec::new());
        self.reserve(roots.len());
    }

    /// Pairs of different bodies that meet, lower index first.
    pub(super) fn pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        self.pairs.iter().map(|pair| pair.bodies).filter(|[i, j]| i != j)
    }

    /// Whether a body is near another one in this step.
    pub(super) fn is_near(&self, body: usize) -> bool {
        self.near.get(body).copied().unwrap_or(false)
    }

    /// Forgets what follows from the nodes and the surface of a body, after a change of them.
    pub(super) fn changed(&mut self, body: usize) {
        self.collisions.invalidate(body);
        self.forces.iter_mut().skip(body).take(1).for_each(Vec::clear);
        self.pairs.iter_mut().filter(|pair| pair.bodies.contains(&body)).for_each(|pair| pair.slack = 0.0);
    }

    /// Forces of contact under which a body with `nodes` nodes is to move, N (n x 3); empty for none, and for a sheet that meets itself, whose
    /// contacts come and go.
    pub(super) fn load(&mut self, body: usize, nodes: usize) -> &[Vec3] {
        let meets_itself = self.pairs.iter().any(|pair| pair.bodies == [body; 2]);
        match self.forces.get(body) {
            Some(forces) if self.near[body] && !meets_itself && forces.len() == nodes => {
                self.is_loaded[body] = true;
                forces
            }
            _ => &[],
        }
    }

    /// Impulse of other bodies on a body in the last step, N s.
    fn impulse(&self, body: usize) -> Vec3 {
        self.collisions.impulse(body)
    }

    /// Whether no bodies may meet, and none are stitched together.
    fn is_idle(&self) -> bool {
        self.pairs.is_empty() && self.tied.is_empty()
    }

    /// Finds the bodies that may meet in a step, before they move under this gravity (m/s^2), and records where they are. What is met by something that moves
    /// wakes up.
    pub(super) fn begin(&mut self, bodies: &[Body], ties: &Ties, motion: &mut Motion, gravity: Vec3, time: StepTime) {
        ties.find_pairs(bodies, &mut self.tied);
        if self.is_idle() {
            return;
        }
        let start = Instant::now();
        self.reserve(bodies.len());
        self.collisions.begin();
        self.near.fill(false);
        self.is_loaded.fill(false);
        let fall = 2.0 * time.dt * time.dt * gravity.norm();
        for pair in &mut self.pairs {
            let [i, j] = pair.bodies;
            let reach = |b: usize| fall + 2.0 * motion.moved[b] + NEAR * bodies[b].discretization.edge();
            let reach = reach(i) + reach(j);
            if i != j && pair.slack <= reach {
                pair.slack = distance(&bounds(&bodies[i]), &bounds(&bodies[j]));
            }
            let is_tied = self.tied.binary_search(&pair.bodies).is_ok();
            pair.is_near = !is_tied && (i == j || pair.slack <= reach);
            if pair.is_near {
                pair.bodies.iter().for_each(|b| self.near[*b] = true);
            }
        }
        self.tied.iter().flatten().for_each(|b| self.near[*b] = true);
        // A sheet is always near itself; it is in contact if anything of it came near in the last step.
        let has_candidates = std::mem::take(&mut self.report).candidates > 0;
        for (index, body) in bodies.iter().enumerate() {
            let may_touch = |pair: &CollisionPair| pair.is_near && (pair.bodies[0] != pair.bodies[1] || has_candidates);
            let mut pairs = self.pairs.iter().filter(|pair| pair.bodies.contains(&index));
            let is_tied = self.tied.iter().any(|pair| pair.contains(&index));
            motion.integrators[index].in_contact = is_tied || pairs.any(may_touch);
            if self.near[index] {
                self.collisions.record_start(index, body);
            }
        }
        let near = self.pairs.iter().filter(|pair| pair.is_near).map(|pair| pair.bodies);
        for pair in near.chain(self.tied.iter().copied()) {
            motion.wake_each_other(pair, time.dt);
        }
        self.seconds = start.elapsed().as_secs_f64();
    }

    /// Finds the pairs that the motion of a step has brought near each other; `moved` is the largest displacement of a node of each body, m.
    fn find_met(&mut self, moved: &[f64]) {
        for pair in &mut self.pairs {
            let [i, j] = pair.bodies;
            pair.slack -= moved[i] + moved[j];
            let is_tied = self.tied.binary_search(&pair.bodies).is_ok();
            pair.is_near |= !is_tied && pair.slack <= 0.0;
        }
    }

    /// Writes the bodies that are near others or stitched to them, each once, ascending.
    fn find_members(&self, members: &mut Vec<usize>) {
        members.clear();
        members.extend(self.pairs.iter().filter(|pair| pair.is_near).flat_map(|pair| pair.bodies));
        members.extend(self.tied.iter().flatten());
        members.sort_unstable();
        members.dedup();
    }

    /// Excludes pairs of bodies whose surfaces cross at the start: they would hold each other for good. Returns the bodies of each, with the number of edges
    /// that go through triangles.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(super) fn exclude_crossing_pairs(
        &mut self,
        bodies: &mut [Body],
    ) -> Result<Vec<([usize; 2], usize)>, SessionError> {
        let mut excluded = Vec::new();
        for pair in &self.pairs {
            let [i, j] = pair.bodies;
            if i != j && distance(&bounds(&bodies[i]), &bounds(&bodies[j])) > 0.0 {
                continue;
            }
            let found = self.collisions.crossings(pair.bodies, bodies);
            let count = found.map_err(|error| SessionError::Lattice { body: bodies[i].name.clone(), error })?;
            if count > 0 {
                excluded.push((pair.bodies, count));
            }
        }
        self.pairs.retain(|pair| !excluded.iter().any(|(bodies, _)| *bodies == pair.bodies));
        Ok(excluded)
    }
}

/// The box of the nodes of a body, m. Its surface is inside, for weights are not negative.
fn bounds(body: &Body) -> [Vec3; 2] {
    let start = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    body.system.nodes.x.iter().fold(start, |[low, high], x| [low.inf(x), high.sup(x)])
}

/// Distance of two boxes along the axis on which it is largest, m; negative if they overlap.
fn distance(a: &[Vec3; 2], b: &[Vec3; 2]) -> f64 {
    (0..3).map(|c| (b[0][c] - a[1][c]).max(a[0][c] - b[1][c])).fold(f64::NEG_INFINITY, f64::max)
}

/// Gap between boxes within which bodies are near, in edges.
const NEAR: f64 = 0.2;

impl Session {
    /// Takes the collisions of a step away, after all bodies have moved.
    pub(super) fn resolve_body_contact(&mut self, time: StepTime) {
        if self.interactions.body_contacts.is_idle() {
            return;
        }
        let start = Instant::now();
        let mut body_contacts = std::mem::take(&mut self.interactions.body_contacts);
        body_contacts.find_met(&self.motion.moved);
        let mut members = std::mem::take(&mut body_contacts.members);
        body_contacts.find_members(&mut members);
        members.retain(|&index| self.prepare_member(&mut body_contacts, index, time));
        let place = |body: usize| members.binary_search(&body).ok();
        let members_of = |[i, j]: [usize; 2]| match (place(i), place(j)) {
            (Some(a), Some(b)) if !(self.stands(i) && self.stands(j)) => Some([a, b]),
            _ => None,
        };
        let mut has_pairs = false;
        for pair in body_contacts.pairs.iter().filter(|pair| pair.is_near) {
            if let Some(members) = members_of(pair.bodies) {
                body_contacts.collisions.add_pair(members, pair.friction);
                has_pairs = true;
            }
        }
        let max_force = |tool: usize| self.tools[tool].tool.coupling.max_force;
        let collisions = &mut body_contacts.collisions;
        has_pairs |= self.interactions.ties.add_rows(collisions, &self.bodies, time, members_of, max_force);
        if has_pairs || members.iter().any(|index| body_contacts.is_loaded[*index]) {
            self.resolve_collisions(&mut body_contacts, &members, time);
        }
        for (index, forces) in body_contacts.forces.iter_mut().enumerate() {
            match place(index).filter(|_| has_pairs && self.motion.is_implicit()) {
                Some(member) => body_contacts.collisions.forces(member, time.dt, forces),
                None => forces.clear(),
            }
        }
        for &index in &members {
            if !self.stands(index) {
                self.rest(index, self.motion.moved[index] / time.dt, time);
            }
        }
        let on_tied = |tool: usize| self.tools[tool].has_tied = true;
        self.interactions.ties.advance(&mut body_contacts.collisions, &mut self.bodies, time, on_tied);
        body_contacts.members = members;
        body_contacts.seconds += start.elapsed().as_secs_f64();
        self.interactions.body_contacts = body_contacts;
    }

    /// Whether nothing moves a body: it is in quarantine, or it sleeps.
    fn stands(&self, index: usize) -> bool {
        self.motion.stands(index, &self.bodies[index])
    }

    /// Adds a body to those that may meet. Returns whether its surface could be made.
    fn prepare_member(&mut self, body_contacts: &mut BodyContacts, index: usize, time: StepTime) -> bool {
        let BodyContacts { collisions, forces, is_loaded, .. } = body_contacts;
        if self.bodies[index].system.nodes.is_empty() {
            return false;
        }
        if let Err(error) = collisions.prepare(index, &mut self.bodies[index]) {
            self.freeze(index, time.start, error.to_string());
            return false;
        }
        let stands = self.stands(index);
        let predicted = if is_loaded[index] { &forces[index][..] } else { &[] };
        collisions.add_member(index, &self.bodies[index], time.dt, stands, self.interactions.held(index), predicted);
        true
    }

    fn resolve_collisions(&mut self, body_contacts: &mut BodyContacts, members: &[usize], time: StepTime) {
        let Self { bodies, tools, motion, guard, .. } = self;
        let mut responses =
            BodyResponses::new(bodies, tools, motion, &guard.cancel, time, &mut body_contacts.responses);
        let report = body_contacts.collisions.resolve(time.dt, &mut responses);
        for (index, why) in responses.end() {
            self.freeze(index, time.start, why);
        }
        body_contacts.report = report;
        for (place, &index) in members.iter().enumerate() {
            if !report.has_pushed || self.stands(index) {
                continue;
            }
            body_contacts.collisions.write_back(place, &mut self.bodies[index]);
            self.motion.record_velocities(index, &self.bodies[index].system.nodes.v, time.dt);
        }
        if report.left > 0 {
            self.events.add_many(EventKind::CollisionsLeft, report.left as u64, time.start, || {
                format!("{} collisions between bodies are left in a step: surfaces may cut into each other; take a shorter step", report.left)
            });
        }
    }

    /// Number of edges that go through triangles between the surfaces of two moving bodies, or of one body.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn crossings(&mut self, a: usize, b: usize) -> Result<usize, LatticeError> {
        let mut collisions = BodyCollisions::new(self.bodies.len());
        collisions.crossings([a, b], &mut self.bodies)
    }

    /// Wall-clock time of contact between bodies in the last step, s; part of [`super::Frame::seconds`].
    pub fn body_contact_seconds(&self) -> f64 {
        self.interactions.body_contacts.seconds
    }

    /// What contact between bodies did in the last step.
    pub fn collision_report(&self) -> CollisionReport {
        self.interactions.body_contacts.report
    }

    /// Force of other bodies on a moving body, mean over the last step, N.
    pub fn contact_force(&self, body: usize) -> Vec3 {
        self.interactions.body_contacts.impulse(body) / self.clock.dt
    }
}
