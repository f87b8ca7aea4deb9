//! Holds the nodes of points that would enter an obstacle, by constraints.

use super::placed::ContactPlane;
use super::points::Point;
use super::{NONE, ObstacleContacts};
use crate::contact::held::{MIN_REBOUND_SPEED, State, Touched, VertexContact};
use pliant_solver::{Constraint, System, TrialStep, Vec3};

/// Largest speed at which a point that is inside is pushed out, relative to the obstacle, m/s.
const MAX_CORRECTION_SPEED: f64 = 0.5;
/// Cosine of the angle between two normals above which they count as one.
const ONE_NORMAL: f64 = 0.95;

/// Position of a node before the step, m ([`TrialStep::start`]).
type Start<'a> = dyn Fn(&System, usize) -> Vec3 + 'a;

impl ObstacleContacts {
    /// Normal velocity, m/s, that brings a point at `x` (m) with this plane onto the surface by the end of the substep.
    fn target(&self, obstacle: usize, x: Vec3, plane: &ContactPlane) -> f64 {
        let towards = self.obstacles[obstacle].velocity_at(x).dot(&plane.normal);
        (towards - plane.gap / self.dt).min(towards.max(0.0) + MAX_CORRECTION_SPEED)
    }

    /// Brings the nodes of a point into contact. Returns whether any constraint has changed. A node that was released is held again, and stays so for the
    /// substep.
    pub(super) fn hold(
        &mut self,
        point: &Point,
        x: Vec3,
        plane: &ContactPlane,
        system: &mut System,
        start: &Start<'_>,
    ) -> bool {
        self.hold_nodes(point.constrained(), point.obstacle as usize, x, plane, system, start)
    }

    /// As [`Self::hold`], of these nodes of a point.
    fn hold_nodes(
        &mut self,
        nodes: impl Iterator<Item = u32>,
        obstacle: usize,
        x: Vec3,
        plane: &ContactPlane,
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
                let contact = self.new_contact(node, x, obstacle, plane.normal, target, system);
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
        node: u32,
        x: Vec3,
        obstacle: usize,
        normal: Vec3,
        target: f64,
        system: &System,
    ) -> VertexContact {
        let before = self.previous.of(node).filter(|last| last.touched.first == obstacle);
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
            touched: Touched::one(obstacle),
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
    pub(super) fn constrain(&self, contact: &VertexContact, x: Vec3, system: &mut System) {
        let i = contact.node as usize;
        let (n, drive) = (contact.normal, self.obstacles[contact.touched.first].velocity_at(x));
        let [a, b] = contact.target;
        let (constraint, prescribed) = match (contact.state, contact.touched.second) {
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

    /// Holds the points that a trial step brings into an obstacle. Returns whether there are any.
    pub(super) fn hold_entering(&mut self, system: &mut System, trial: &TrialStep<'_>) -> bool {
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
            changed |= self.hold_nodes(node, point.obstacle as usize, start, &plane, system, trial.start);
        }
        changed
    }
}

/// Adds a plane to the contact of a node. Returns whether the contact has changed.
fn join(contact: &mut VertexContact, obstacle: usize, normal: Vec3, target: f64) -> bool {
    let is_one = |other: &Vec3| other.dot(&normal) > ONE_NORMAL;
    if contact.state == State::Free {
        (contact.touched, contact.normal, contact.target) = (Touched::one(obstacle), normal, [target, 0.0]);
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
        if contact.touched.second.is_none() {
            (contact.touched.first, contact.normal, contact.rebound) = (obstacle, normal, 0.0);
        }
        return true;
    }
    if contact.touched.second.is_some() {
        if !is_one(&contact.other) || target <= contact.target[1] {
            return false; // a third plane is left to the correction after the step
        }
        contact.target[1] = target;
        return true;
    }
    if contact.normal.dot(&normal) < -ONE_NORMAL {
        return false; // squeezed between two obstacles, which leave no room
    }
    (contact.touched.second, contact.other, contact.target[1]) = (Some(obstacle), normal, target);
    (contact.state, contact.friction) = (State::Slides, Vec3::zeros());
    true
}
