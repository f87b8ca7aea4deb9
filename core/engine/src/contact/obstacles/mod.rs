//! Contact of a body with obstacles by constraints on its nodes.
//!
//! A point of the body that would enter an obstacle in a step constrains the nodes that carry it: their velocity along the normal becomes the one
//! that brings the point onto the surface. On a sheet a point is a vertex and the constraint is exact. In a solid it is a vertex or a sample of the
//! surface, and the nodes are the corners of its cell: since the weights are positive, no point of the cell enters if no corner comes closer than
//! its closest point (contact at the nodes of the grid: Bardenhagen, Brackbill and Sulsky 2000). Sticking, sliding and release are those of
//! fingertips ([`VertexContact`]): the solver computes the constraint force, one that pulls releases, one outside of the friction cone lets slide.
//! Where two surfaces meet, as in a corner, a node moves along both.
//!
//! The points of a solid follow the trilinear weights, also where its surface is smooth: a constraint whose derivative is not that of the points would do
//! work on the body. Drawn vertices are moved the few hundredths of a cell out by which the smooth surface differs.
//!
//! Points that are inside all the same, because the active set did not settle or a scheme moves before it knows, are moved out after the step.

mod body_contacts;
mod placed;
mod points;

pub use body_contacts::BodyContacts;
pub use placed::PlacedObstacle;

use super::held::{MIN_REBOUND_SPEED, State, VertexContact, is_settled};
use crate::body::{Body, Discretization, LatticeError};
use crate::obstacle::Nearest;
use placed::ContactPlane;
use pliant_solver::{Constraint, ContactConstraints, System, TrialStep, Vec3};
use points::{Candidates, Point};

/// Contact of one body with all obstacles.
#[derive(Default)]
pub struct ObstacleContacts {
    /// The obstacles, at the beginning of the substep.
    obstacles: Vec<PlacedObstacle>,
    /// Force on each obstacle, N: the mean over the substeps since [`ObstacleContacts::place`].
    pub force: Vec<Vec3>,
    /// Energy that friction with each obstacle dissipated since then, J.
    pub friction_work: Vec<f64>,
    /// Length of the step in which forces are averaged, s.
    span: f64,
    candidates: Candidates,
    /// Points that may meet an obstacle in this step.
    points: Vec<Point>,
    /// Position and gap of each point at the beginning of the substep, m.
    starts: Vec<(Vec3, f64)>,
    /// Contacts of this substep; `place_of` has their indices.
    contacts: Vec<VertexContact>,
    /// Index of the contact of each node, or [`NONE`] (n).
    place_of: Vec<u32>,
    /// Whether a node is held by a fixing (n).
    fixed: Vec<bool>,
    /// Contacts of the last substep, nodes ascending.
    previous: Vec<PreviousContact>,
    /// The same before a step that may be taken again.
    start: Vec<PreviousContact>,
    /// Substeps since [`ObstacleContacts::place`], s.
    elapsed: f64,
    /// Length of the substep, s.
    dt: f64,
    /// Distance that counts as contact, m: rounding.
    tolerance: f64,
    /// Distance within which a node that was in contact stays in it, m.
    follow: f64,
    /// Depth up to which the nodes of little weight may bring a point in within a step, m.
    turn: f64,
}

/// A contact of the last substep.
#[derive(Clone, Copy)]
struct PreviousContact {
    node: u32,
    obstacle: usize,
    /// Friction force, N, if it keeps sliding.
    friction: Option<Vec3>,
}

/// Value of `place_of` for a node without contact.
const NONE: u32 = u32::MAX;
/// Largest speed at which a point that is inside is pushed out, relative to the obstacle, m/s.
const MAX_CORRECTION_SPEED: f64 = 0.5;
/// Depth that counts as rounding, in edges of the body.
const TOLERANCE: f64 = 1e-7;
/// Distance within which a contact stays, in edges of the body.
const FOLLOW: f64 = 1e-4;
/// Depth up to which the nodes of little weight may bring a point in within a step, in edges: a step at the speeds of a fall is tens of times as long.
const TURN: f64 = 1e-3;
/// Cosine of the angle between two normals above which they count as one.
const ONE_NORMAL: f64 = 0.95;
/// Largest depth, in edges of a cell, from which a drawn vertex is moved out.
const DRAWN: f64 = 0.25;
/// Number of times that points which are inside after a step are moved out; one move may bring another point in.
const MAX_CORRECTIONS: usize = 8;

/// Position of a node before the step, m ([`TrialStep::start`]).
type Start<'a> = dyn Fn(&System, usize) -> Vec3 + 'a;

impl ObstacleContacts {
    /// Contact with obstacles that [`ObstacleContacts::place`] sets.
    pub fn new() -> Self {
        Self::default()
    }

    /// Nodes that obstacles hold at the end of the step, with the directions in which they are free.
    pub fn held(&self) -> impl Iterator<Item = (u32, Constraint)> + '_ {
        let near = if self.is_near() { &self.contacts[..] } else { &[] };
        near.iter().filter_map(|contact| match (contact.state, contact.tips.1) {
            (State::Free, _) => None,
            (State::Slides, None) => Some((contact.node, Constraint::Plane(contact.normal))),
            (State::Sticks, None) => Some((contact.node, Constraint::Fixed)),
            (_, Some(_)) => Some((contact.node, Constraint::Line(contact.normal.cross(&contact.other).normalize()))),
        })
    }

    /// Drops all contacts and candidates, as after a change of the body's nodes.
    pub fn invalidate(&mut self) {
        self.candidates.invalidate();
        self.previous.clear();
    }

    /// Prepares a step of `span` (s) with the obstacles where they are at its beginning. Since the last call body and obstacles have moved by `moved`, and in
    /// this step they move by up to `reach` (both in m).
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn place(
        &mut self,
        body: &mut Body,
        obstacles: impl Iterator<Item = PlacedObstacle>,
        span: f64,
        [moved, reach]: [f64; 2],
    ) -> Result<(), LatticeError> {
        self.obstacles.clear();
        self.obstacles.extend(obstacles);
        self.force.clear();
        self.force.resize(self.obstacles.len(), Vec3::zeros());
        self.friction_work.clear();
        self.friction_work.resize(self.obstacles.len(), 0.0);
        let edge = body.discretization.edge();
        self.elapsed = 0.0;
        (self.span, self.tolerance, self.follow, self.turn) = (span, TOLERANCE * edge, FOLLOW * edge, TURN * edge);
        self.candidates.find(body, &self.obstacles, moved, reach, &mut self.points)
    }

    /// Whether any point may meet an obstacle in this step.
    pub fn is_near(&self) -> bool {
        !self.points.is_empty()
    }

    fn previous(&self, node: u32) -> Option<PreviousContact> {
        self.previous.binary_search_by_key(&node, |last| last.node).ok().map(|at| self.previous[at])
    }

    fn is_fixed(&self, node: u32) -> bool {
        self.fixed[node as usize]
    }

    /// Normal velocity, m/s, that brings a point at `x` (m) with this plane onto the surface by the end of the substep.
    fn target(&self, obstacle: usize, x: Vec3, plane: &ContactPlane) -> f64 {
        let towards = self.obstacles[obstacle].velocity_at(x).dot(&plane.normal);
        (towards - plane.gap / self.dt).min(towards.max(0.0) + MAX_CORRECTION_SPEED)
    }

    /// Records which nodes are held before any contact constrains them.
    fn find_fixed(&mut self, system: &System) {
        self.fixed.clear();
        self.fixed.extend(system.nodes.constraint.iter().map(|constraint| !constraint.is_free()));
    }

    /// Brings the nodes of a point into contact. Returns whether any constraint has changed. A node that was released is held again, and stays so for the
    /// substep.
    fn hold(&mut self, point: &Point, x: Vec3, plane: &ContactPlane, system: &mut System, start: &Start<'_>) -> bool {
        self.hold_nodes(point.constrained(), point.obstacle as usize, (x, plane), system, start)
    }

    /// As [`Self::hold`], of these nodes of a point.
    fn hold_nodes(
        &mut self,
        nodes: impl Iterator<Item = u32>,
        obstacle: usize,
        (x, plane): (Vec3, &ContactPlane),
        system: &mut System,
        start: &Start<'_>,
    ) -> bool {
        let (target, towards) = (self.target(obstacle, x, plane), self.obstacles[obstacle].velocity_at(x));
        let mut changed = false;
        for node in nodes {
            if self.is_fixed(node) {
                continue;
            }
            let i = node as usize;
            let place = self.place_of[i];
            // Where the obstacle turns, the node moves with the obstacle where the node is.
            let turned = self.obstacles[obstacle].velocity_at(start(system, i)) - towards;
            let target = target + turned.dot(&plane.normal);
            if place == NONE {
                if !system.nodes.constraint[i].is_free() {
                    changed |= self.keep_out(i, plane.normal, target, system); // a tip holds it
                    continue;
                }
                let x = start(system, i);
                let contact = self.new_contact((node, x), obstacle, plane.normal, target, system);
                self.place_of[i] = self.contacts.len() as u32;
                self.constrain(&contact, x, system);
                self.contacts.push(contact);
                changed = true;
                continue;
            }
            let mut contact = self.contacts[place as usize];
            if join(&mut contact, obstacle, plane.normal, target) {
                self.constrain(&contact, start(system, i), system);
                self.contacts[place as usize] = contact;
                changed = true;
            }
        }
        changed
    }

    /// Keeps a node that a tip holds out of an obstacle. Returns whether its velocity has changed.
    fn keep_out(&self, i: usize, normal: Vec3, target: f64, system: &mut System) -> bool {
        let nodes = &mut system.nodes;
        let held = nodes.constraint[i].merge(nodes.v[i], nodes.prescribed[i]);
        let short = target - held.dot(&normal);
        if short <= self.tolerance / self.dt {
            return false;
        }
        (nodes.constraint[i], nodes.prescribed[i]) = (Constraint::Fixed, held + short * normal);
        true
    }

    /// A contact of a node that is at `x` (m) before the step.
    fn new_contact(
        &self,
        (node, x): (u32, Vec3),
        obstacle: usize,
        normal: Vec3,
        target: f64,
        system: &System,
    ) -> VertexContact {
        let before = self.previous(node).filter(|last| last.obstacle == obstacle);
        let placed = &self.obstacles[obstacle];
        let v = system.nodes.v[node as usize];
        let drive = placed.velocity_at(x);
        let past = v - drive;
        let speed = -past.dot(&normal);
        let rebound = if before.is_none() && speed > MIN_REBOUND_SPEED { placed.restitution * speed } else { 0.0 };
        let target = if rebound > 0.0 { target.max(drive.dot(&normal) + rebound) } else { target };
        let slip = past - past.dot(&normal) * normal;
        // A new contact sticks unless it is faster along the surface than friction can stop in the substep.
        let stops = placed.friction.kinetic_coefficient * (target - v.dot(&normal)).max(0.0);
        let slides = before.map_or(slip.norm() > stops, |last| last.friction.is_some());
        VertexContact {
            node,
            tips: (obstacle, None),
            normal,
            other: Vec3::zeros(),
            target: [target, 0.0],
            rebound,
            state: if slides { State::Slides } else { State::Sticks },
            stuck_before: before.is_some() && !slides,
            caught: false,
            friction: before.and_then(|last| last.friction).map_or(Vec3::zeros(), |f| f - f.dot(&normal) * normal),
            returned: false,
        }
    }

    /// Sets the constraint and the prescribed velocity of a node, at `x` (m) before the step, from its contact state.
    fn constrain(&self, contact: &VertexContact, x: Vec3, system: &mut System) {
        let i = contact.node as usize;
        let (n, drive) = (contact.normal, self.obstacles[contact.tips.0].velocity_at(x));
        let [a, b] = contact.target;
        let (constraint, prescribed) = match (contact.state, contact.tips.1) {
            (State::Free, _) => (Constraint::Free, Vec3::zeros()),
            (State::Slides, None) => (Constraint::Plane(n), a * n),
            (State::Sticks, None) => (Constraint::Fixed, drive + (a - drive.dot(&n)) * n),
            (_, Some(_)) => {
                // The velocity in the plane of the two normals follows from both normal velocities by their 2 x 2 Gram matrix.
                let c = n.dot(&contact.other);
                let determinant = 1.0 - c * c;
                let velocity = (a - c * b) / determinant * n + (b - c * a) / determinant * contact.other;
                (Constraint::Line(n.cross(&contact.other).normalize()), velocity)
            }
        };
        (system.nodes.constraint[i], system.nodes.prescribed[i]) = (constraint, prescribed);
    }

    /// The transition of a contact under a trial step, and whether it is certain.
    fn transition(
        &self,
        contact: &VertexContact,
        system: &System,
        trial: &TrialStep<'_>,
    ) -> Option<(VertexContact, bool)> {
        let placed = &self.obstacles[contact.tips.0];
        let Some(second) = contact.tips.1 else {
            let drive = placed.velocity_at((trial.start)(system, contact.node as usize));
            return contact.transition(placed.friction, drive, system, trial);
        };
        if contact.caught {
            return None;
        }
        // Of a node on two planes the one that pulls is dropped.
        let node = contact.node as usize;
        let lambda = (trial.reaction)(node);
        let c = contact.normal.dot(&contact.other);
        let (p, q) = (lambda.dot(&contact.normal), lambda.dot(&contact.other));
        let [a, b] = [(p - c * q) / (1.0 - c * c), (q - c * p) / (1.0 - c * c)];
        if a >= 0.0 && b >= 0.0 {
            return None;
        }
        let (kept, normal, target) = match a >= b {
            true => (contact.tips.0, contact.normal, contact.target[0]),
            false => (second, contact.other, contact.target[1]),
        };
        let error = trial.error_bound.map_or(0.0, |bound| {
            bound(system, node, contact.normal)[0].max(bound(system, node, contact.other)[0]) / (1.0 - c * c)
        });
        let next = VertexContact { tips: (kept, None), normal, target: [target, 0.0], ..*contact };
        Some((next, a.min(b) < -2.0 * error))
    }

    /// Holds the points that a trial step brings into an obstacle. Returns whether there are any.
    fn hold_entering(&mut self, system: &mut System, trial: &TrialStep<'_>) -> bool {
        let (velocity, mut changed) = (trial.velocity, false);
        for at in 0..self.points.len() {
            let point = self.points[at];
            let v = point.mean(|i| velocity(system, i));
            let placed = &self.obstacles[point.obstacle as usize];
            let (start, gap) = self.starts[at];
            let way = self.dt * (v - placed.velocity_at(start));
            if gap - way.norm() >= -self.tolerance {
                continue;
            }
            // It must not come deeper than it was.
            let plane = placed.plane(start, v, self.dt);
            let deeper = plane.gap.min(0.0) - (plane.gap + plane.normal.dot(&way));
            if deeper <= self.tolerance {
                continue;
            }
            if self.hold(&point, start, &plane, system, trial.start) {
                changed = true;
                continue;
            }
            // Its nodes are held, and those that carry less of it bring it in, as where a body turns. Moving it out after the step would do work, so
            // the one that brings it furthest is held too; not for the little way of a body at rest, where nodes would be held and let go by turns.
            if deeper <= self.turn {
                continue;
            }
            let target = self.target(point.obstacle as usize, start, &plane);
            let inwards = |node: u32| target - velocity(system, node as usize).dot(&plane.normal);
            let free = point.carriers().filter(|(node, _)| !self.is_fixed(*node));
            let furthest = free.max_by(|a, b| (a.1 * inwards(a.0)).total_cmp(&(b.1 * inwards(b.0))));
            let node = furthest.map(|(node, _)| node).into_iter();
            changed |= self.hold_nodes(node, point.obstacle as usize, (start, &plane), system, trial.start);
        }
        changed
    }

    /// Moves the points out that are deeper in an obstacle after the substep than before it, and takes their velocity inwards.
    fn move_out(&mut self, system: &mut System) {
        for _ in 0..MAX_CORRECTIONS {
            let mut is_done = true;
            for at in 0..self.points.len() {
                let point = &self.points[at];
                let index = point.obstacle as usize;
                let placed = &self.obstacles[index];
                let x = point.position(&system.nodes);
                let now = placed.nearest_after(x, self.dt);
                let excess = self.starts[at].1.min(0.0) - now.distance;
                let free = point.carriers().filter(|(node, _)| !self.fixed[*node as usize]);
                let squares: f64 = free.clone().map(|(_, w)| w * w).sum();
                if excess <= self.tolerance || squares == 0.0 {
                    continue;
                }
                is_done = false;
                let inwards = (point.mean(|i| system.nodes.v[i]) - placed.velocity_at(x)).dot(&now.normal).min(0.0);
                for (node, weight) in free {
                    let (i, share) = (node as usize, weight / squares);
                    system.nodes.x[i] += share * excess * now.normal;
                    system.nodes.v[i] -= share * inwards * now.normal;
                    self.force[index] += system.nodes.mass[i] / self.span * share * inwards * now.normal;
                }
            }
            if is_done {
                break;
            }
        }
    }

    /// Moves vertices of a solid that is drawn smoothly out of obstacles: contact knows the weights of the grid, from which the smooth surface differs by
    /// a few hundredths of a cell, and more in a crash. What is deeper than a quarter of a cell is no matter of drawing and stays.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn clear_skin(&self, body: &mut Body) -> Result<(), LatticeError> {
        let Body { discretization: Discretization::Lattice(lattice), skin, .. } = body else { return Ok(()) };
        for &(obstacle, cell) in self.candidates.near() {
            let placed = &self.obstacles[obstacle as usize];
            for &v in lattice.points(cell)? {
                let Nearest { distance, normal } = placed.nearest(skin.x[v as usize]);
                if distance < 0.0 && distance > -DRAWN * lattice.edge() {
                    skin.x[v as usize] -= distance * normal;
                    skin.pages.mark(v);
                }
            }
        }
        Ok(())
    }
}

/// Adds a plane to the contact of a node. Returns whether the contact has changed.
fn join(contact: &mut VertexContact, obstacle: usize, normal: Vec3, target: f64) -> bool {
    let is_one = |other: &Vec3| other.dot(&normal) > ONE_NORMAL;
    if contact.state == State::Free {
        (contact.tips, contact.normal, contact.target) = ((obstacle, None), normal, [target, 0.0]);
        (contact.state, contact.caught, contact.friction) = (State::Slides, true, Vec3::zeros());
        contact.rebound = 0.0; // it was that of another contact
        return true;
    }
    // Of nearly parallel planes the one that pushes more counts. Of two planes the normals stay: they might become parallel.
    if is_one(&contact.normal) {
        if target <= contact.target[0] {
            return false;
        }
        contact.target[0] = target;
        if contact.tips.1.is_none() {
            (contact.tips.0, contact.normal, contact.rebound) = (obstacle, normal, 0.0);
        }
        return true;
    }
    if contact.tips.1.is_some() {
        if !is_one(&contact.other) || target <= contact.target[1] {
            return false; // a third plane is left to the correction after the step
        }
        contact.target[1] = target;
        return true;
    }
    if contact.normal.dot(&normal) < -ONE_NORMAL {
        return false; // squeezed between two obstacles, which leave no room
    }
    (contact.tips.1, contact.other, contact.target[1]) = (Some(obstacle), normal, target);
    (contact.state, contact.friction) = (State::Slides, Vec3::zeros());
    true
}

impl ContactConstraints for ObstacleContacts {
    fn begin(&mut self, system: &mut System, dt: f64) {
        self.dt = dt;
        self.contacts.clear();
        self.place_of.clear();
        self.place_of.resize(system.nodes.len(), NONE);
        self.starts.clear();
        for at in 0..self.points.len() {
            let point = self.points[at];
            let placed = &self.obstacles[point.obstacle as usize];
            let (x, v) = (point.position(&system.nodes), point.mean(|i| system.nodes.v[i]));
            let start = placed.nearest(x);
            self.starts.push((x, start.distance));
            let way = dt * (v - placed.velocity_at(x));
            let plane = match start.distance > way.norm() {
                true => ContactPlane { normal: start.normal, gap: start.distance },
                false => placed.plane(x, v, dt),
            };
            let enters = plane.gap + plane.normal.dot(&way) < -self.tolerance;
            let was_here = |node| self.previous(node).is_some_and(|last| last.obstacle == point.obstacle as usize);
            if enters || (start.distance <= self.follow && point.constrained().all(was_here)) {
                self.hold(&point, x, &plane, system, &|s, i| s.nodes.x[i]);
            }
        }
    }

    fn add_forces(&self, force: &mut [Vec3]) {
        for contact in self.contacts.iter().filter(|contact| contact.state == State::Slides) {
            force[contact.node as usize] += contact.friction;
        }
    }

    fn update_active_set(&mut self, system: &mut System, trial: &TrialStep<'_>) -> bool {
        let mut changed = false;
        for at in 0..self.contacts.len() {
            if let Some((next, true)) = self.transition(&self.contacts[at], system, trial) {
                self.contacts[at] = next;
                let x = (trial.start)(system, next.node as usize);
                self.constrain(&next, x, system);
                changed = true;
            }
        }
        (trial.error_bound.is_none() && self.hold_entering(system, trial)) || changed
    }

    fn can_stop_early(&self, system: &System, trial: &TrialStep<'_>) -> bool {
        is_settled(self.contacts.iter().map(|contact| self.transition(contact, system, trial)))
    }

    fn has_candidates(&self) -> bool {
        !self.points.is_empty()
    }

    fn is_active(&self) -> bool {
        !self.contacts.is_empty()
    }

    fn keep_start(&mut self) {
        self.start.clone_from(&self.previous);
        // They may name nodes that are others by now.
        self.contacts.clear();
    }

    fn take_back(&mut self, system: &mut System) {
        self.previous.clone_from(&self.start);
        self.force.fill(Vec3::zeros());
        self.friction_work.fill(0.0);
        for placed in &mut self.obstacles {
            placed.advance(-self.elapsed);
        }
        self.elapsed = 0.0;
        for contact in self.contacts.drain(..) {
            system.nodes.release(contact.node);
        }
    }

    fn end(&mut self, system: &mut System, reaction: &mut [Vec3]) {
        self.previous.clear();
        let share = self.dt / self.span;
        for contact in &self.contacts {
            let i = contact.node as usize;
            let index = contact.tips.0;
            let placed = &self.obstacles[index];
            if contact.state != State::Free {
                let slides = contact.state == State::Slides;
                let on_node = reaction[i] + contact.friction;
                match contact.tips.1 {
                    None => self.force[index] -= share * on_node,
                    Some(second) => {
                        let c = contact.normal.dot(&contact.other);
                        let (p, q) = (on_node.dot(&contact.normal), on_node.dot(&contact.other));
                        self.force[index] -= share * (p - c * q) / (1.0 - c * c) * contact.normal;
                        self.force[second] -= share * (q - c * p) / (1.0 - c * c) * contact.other;
                    }
                }
                let slip = system.nodes.v[i] - placed.velocity_at(system.nodes.x[i]);
                let next_friction =
                    || contact.next_friction(placed.friction, reaction[i], slip, system.nodes.mass[i], self.dt);
                let friction = slides.then(next_friction).flatten();
                self.previous.push(PreviousContact { node: contact.node, obstacle: index, friction });
                if slides {
                    self.friction_work[index] -= contact.friction.dot(&slip) * self.dt;
                    reaction[i] += contact.friction;
                }
                // The velocity that moved it out of an obstacle was a correction of its position; it is removed again.
                let planes = [(Some(index), contact.normal, contact.rebound), (contact.tips.1, contact.other, 0.0)];
                for (obstacle, n, rebound) in planes.into_iter().filter_map(|(o, n, rebound)| Some((o?, n, rebound))) {
                    let drive = self.obstacles[obstacle].velocity_at(system.nodes.x[i]);
                    let excess = ((system.nodes.v[i] - drive).dot(&n) - rebound).max(0.0);
                    system.nodes.v[i] -= excess * n;
                    let push = system.nodes.mass[i] * excess / self.dt;
                    self.force[obstacle] += share * push * n;
                    reaction[i] -= push * n;
                }
            }
            system.nodes.release(contact.node);
        }
        self.previous.sort_unstable_by_key(|last| last.node);
        self.move_out(system);
        for placed in &mut self.obstacles {
            placed.advance(self.dt);
        }
        self.elapsed += self.dt;
    }
}
