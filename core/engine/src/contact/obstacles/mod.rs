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
mod clearing;
mod holding;
mod placed;
mod points;

pub use body_contacts::BodyContacts;
pub use placed::PlacedObstacle;

use super::held::{State, Touched, VertexContact, is_settled};
use super::previous::{PreviousContact, PreviousContacts};
use crate::body::{Body, LatticeError};
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
    /// Contacts of the last substep.
    previous: PreviousContacts,
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

/// Value of `place_of` for a node without contact.
const NONE: u32 = u32::MAX;
/// Depth that counts as rounding, in edges of the body.
const TOLERANCE: f64 = 1e-7;
/// Distance within which a contact stays, in edges of the body.
const FOLLOW: f64 = 1e-4;
/// Depth up to which the nodes of little weight may bring a point in within a step, in edges: a step at the speeds of a fall is tens of times as long.
const TURN: f64 = 1e-3;

impl ObstacleContacts {
    /// Contact with obstacles that [`ObstacleContacts::place`] sets.
    pub fn new() -> Self {
        Self::default()
    }

    /// Nodes that obstacles hold at the end of the step, with the directions in which they are free.
    pub fn held(&self) -> impl Iterator<Item = (u32, Constraint)> + '_ {
        let near = if self.is_near() { &self.contacts[..] } else { &[] };
        near.iter().filter_map(|contact| match (contact.state, contact.touched.second) {
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
        moved: f64,
        reach: f64,
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

    fn is_fixed(&self, node: u32) -> bool {
        self.fixed[node as usize]
    }

    /// Records which nodes are held before any contact constrains them.
    fn find_fixed(&mut self, system: &System) {
        self.fixed.clear();
        self.fixed.extend(system.nodes.constraint.iter().map(|constraint| !constraint.is_free()));
    }

    /// The transition of a contact under a trial step, and whether it is certain.
    fn transition(
        &self,
        contact: &VertexContact,
        system: &System,
        trial: &TrialStep<'_>,
    ) -> Option<(VertexContact, bool)> {
        let placed = &self.obstacles[contact.touched.first];
        let Some(second) = contact.touched.second else {
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
            true => (contact.touched.first, contact.normal, contact.target[0]),
            false => (second, contact.other, contact.target[1]),
        };
        let error = trial.error_bound.map_or(0.0, |bound| {
            bound(system, node, contact.normal)[0].max(bound(system, node, contact.other)[0]) / (1.0 - c * c)
        });
        let next = VertexContact { touched: Touched::one(kept), normal, target: [target, 0.0], ..*contact };
        Some((next, a.min(b) < -2.0 * error))
    }
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
            let was_here =
                |node| self.previous.of(node).is_some_and(|last| last.touched.first == point.obstacle as usize);
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
        self.previous.keep_start();
        // They may name nodes that are others by now.
        self.contacts.clear();
    }

    fn take_back(&mut self, system: &mut System) {
        self.previous.restore_start();
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
            let index = contact.touched.first;
            let placed = &self.obstacles[index];
            if contact.state != State::Free {
                let slides = contact.state == State::Slides;
                let on_node = reaction[i] + contact.friction;
                match contact.touched.second {
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
                self.previous.add(PreviousContact { node: contact.node, touched: contact.touched, friction });
                if slides {
                    self.friction_work[index] -= contact.friction.dot(&slip) * self.dt;
                    reaction[i] += contact.friction;
                }
                // The velocity that moved it out of an obstacle was a correction of its position; it is removed again.
                let planes =
                    [(Some(index), contact.normal, contact.rebound), (contact.touched.second, contact.other, 0.0)];
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
        self.previous.sort();
        self.move_out(system);
        for placed in &mut self.obstacles {
            placed.advance(self.dt);
        }
        self.elapsed += self.dt;
    }
}
