//! Contact of tips with the vertices of a sheet by constraints.
//!
//! A vertex inside a tip is constrained to the tip's surface for the step: it sticks, and the solver computes the constraint force. A vertex
//! whose constraint force pulls is released. A vertex whose tangential constraint force exceeds the friction cone slides: Coulomb friction
//! (1785) acts as a force and only its normal velocity stays prescribed (Tripicchio, D'Avella and Ruffaldi 2022, with the reaction of the
//! unfiltered system instead of their work). A new contact first sticks, unless its tangential speed exceeds what friction can stop in a step:
//! sticking in a taut sheet would pull it, and the release would let it into the tip. A vertex that slid in the last step keeps sliding with the
//! friction of that step, and sticks if that friction would accelerate it.

use super::fingertip::{Press, SWEEP, Tip, Vertex, contact_normal, goes_far, starts_sliding};
use super::held::{MIN_REBOUND_SPEED, State, Touched, VertexContact, is_settled};
use super::neighbour_list::NeighbourList;
use super::previous::{PreviousContact, PreviousContacts};
use super::tip_motion::{MOST_TRIED, TipMotion};
use pliant_solver::{Constraint, ContactConstraints, MAX_ACTIVE_SET_PASSES, System, TrialStep, Vec3};

/// All tips on one sheet.
#[derive(Default)]
pub struct SheetTips {
    /// Contact points of the last step; `None` if they are not recorded.
    pub presses: Option<Vec<Press>>,
    /// One for each tool.
    pub tips: Vec<Tip>,
    /// Largest displacement of a vertex since the last step, m.
    pub moved: f64,
    /// Energy dissipated by friction in the last step, J.
    pub friction_work: f64,
    /// Whether a soft tip, which does not constrain, touches the sheet.
    pub is_pressed: bool,
    /// Nodes that no tip meets, ascending: those whose triangles have failed.
    loose_nodes: Vec<u32>,
    /// Vertices near each tip.
    near: Vec<NeighbourList>,
    /// Velocity of each tip with a mass in a Newton iteration of an implicit step; empty in explicit steps, which take the force of the step before.
    motions: Vec<TipMotion>,
    /// Full solves in this Newton iteration after which contacts were judged.
    passes: usize,
    /// Contacts of this step, nodes ascending.
    contacts: Vec<VertexContact>,
    /// Length of the step, s.
    dt: f64,
    previous: PreviousContacts,
}

/// Largest speed at which a penetrating vertex is pushed out, relative to the tip, m/s.
const MAX_CORRECTION_SPEED: f64 = 0.5;
/// Distance within which a vertex stays in contact after a pinch or on another tip, in length scales of the tip.
const CONTACT_GAP: f64 = 1e-3;
/// Sine of the angle between two normals below which they count as parallel.
const PARALLEL: f64 = 0.02;

impl SheetTips {
    /// Nodes that tips hold at the end of the step.
    pub fn held(&self) -> impl Iterator<Item = u32> + '_ {
        self.contacts.iter().filter(|contact| contact.state != State::Free).map(|contact| contact.node)
    }

    /// Drops all contacts and invalidates the neighbour lists, as after a change of the body's nodes.
    pub fn invalidate(&mut self) {
        self.near.iter_mut().for_each(NeighbourList::invalidate);
        self.previous.clear();
    }

    /// Forgets the contacts of the last step where there are no tips left: a step without tips does not look at them.
    pub fn forget_lost_contacts(&mut self) {
        if self.tips.is_empty() {
            self.contacts.clear();
            self.previous.clear();
        }
    }

    /// Sets the nodes that no tip meets, ascending.
    pub fn set_loose_nodes(&mut self, nodes: &[u32]) {
        if self.loose_nodes != nodes {
            self.loose_nodes.clear();
            self.loose_nodes.extend_from_slice(nodes);
            self.near.iter_mut().for_each(NeighbourList::invalidate);
        }
    }

    /// Updates the neighbour lists for nodes at `x` (n x 3, m) and a step of `dt` (s).
    fn update_near(&mut self, x: &[Vec3], dt: f64) {
        self.near.resize_with(self.tips.len(), NeighbourList::default);
        for (near, tip) in self.near.iter_mut().zip(&self.tips).filter(|(_, tip)| tip.constrains) {
            // The sheet may move in this step as it did in the last one.
            let travel = dt * tip.velocity.norm() + self.moved;
            let Some(reach) = near.refresh(tip.position, tip.shape.shape(), self.moved, travel) else { continue };
            let within = |i: &u32| (x[*i as usize] - tip.position).norm_squared() <= reach * reach;
            let is_met = |i: &u32| self.loose_nodes.binary_search(i).is_err();
            near.list.extend((0..x.len() as u32).filter(within).filter(is_met));
        }
    }

    /// Whether a tip could touch a vertex of a sheet that stands still at `x` (n x 3, m) in two steps of `dt` (s). Contact of soft tips is by triangles, which
    /// reach as far as an edge, `edge` (m), beside their vertices.
    pub fn may_touch(&mut self, x: &[Vec3], edge: f64, dt: f64) -> bool {
        self.moved = 0.0;
        self.update_near(x, 2.0 * dt);
        self.tips.iter().zip(&self.near).any(|(tip, near)| {
            let reach = tip.shape.shape().bounding_radius() + 2.0 * dt * tip.velocity.norm();
            let within = |reach: f64, at: &Vec3| (at - tip.position).norm_squared() <= reach * reach;
            match tip.constrains {
                true => near.list.iter().any(|v| within(reach, &x[*v as usize])),
                false => x.iter().any(|at| within(reach + edge, at)),
            }
        })
    }

    /// Distance from tip `t` within which a vertex that was in contact in the last step stays in contact, m. It follows a receding tip, as long
    /// as it is pushed, but not after a pinch or on another tip.
    fn gap(&self, t: usize, last: PreviousContact) -> f64 {
        let scale = self.tips[t].length_scale();
        if last.touched == Touched::one(t) {
            (MAX_CORRECTION_SPEED * self.dt).min(SWEEP * scale)
        } else {
            CONTACT_GAP * scale
        }
    }

    /// The transition of a contact under a trial step, with the tip's friction and velocity.
    fn transition(
        &self,
        contact: &VertexContact,
        system: &System,
        trial: &TrialStep<'_>,
    ) -> Option<(VertexContact, bool)> {
        let tip = &self.tips[contact.touched.first];
        contact.transition(tip.friction, tip.velocity_at((trial.start)(system, contact.node as usize)), system, trial)
    }

    /// Velocity along `normal` of tip `t` at a vertex at `x` (m), and the one that brings the vertex onto its surface, both in m/s.
    fn towards(&self, t: usize, x: Vec3, normal: Vec3) -> (f64, f64) {
        let tip = &self.tips[t];
        let towards = tip.velocity_at(x).dot(&normal);
        (towards, (tip.depth(x, normal) / self.dt).min(towards.max(0.0) + MAX_CORRECTION_SPEED))
    }

    /// Gives tips with a mass the velocity that follows from the force of a trial step. Returns whether one has changed, so that the step must be solved
    /// again before contacts are judged. A tip that pinches is left to the next step.
    fn solve_tip_velocities(&mut self, system: &mut System, trial: &TrialStep<'_>) -> bool {
        let mut changed = false;
        for t in 0..self.motions.len() {
            let Some(response) = self.tips[t].response.filter(|response| response.dt == self.dt) else { continue };
            let holds = |contact: &&VertexContact| contact.touched.first == t && contact.state != State::Free;
            if self
                .contacts
                .iter()
                .any(|c| c.touched.second.is_some() && (c.touched.first == t || c.touched.second == Some(t)))
            {
                continue;
            }
            let (mut force, mut momentum, mut mass) = (Vec3::zeros(), Vec3::zeros(), 0.0);
            for contact in self.contacts.iter().filter(holds) {
                let i = contact.node as usize;
                force -= (trial.reaction)(i) + contact.friction;
                // The speed of a correction of its place is removed at the end.
                let towards = self.tips[t].velocity_at((trial.start)(system, i)).dot(&contact.normal);
                let excess = (contact.target[0] - contact.rebound - towards).max(0.0);
                force += system.nodes.mass[i] * excess / self.dt * contact.normal;
                momentum += system.nodes.mass[i] * system.nodes.v[i];
                mass += system.nodes.mass[i];
            }
            if mass == 0.0 && self.tips[t].implicit_force.is_none() {
                continue;
            }
            let sheet = if mass > 0.0 { momentum / mass } else { Vec3::zeros() };
            let tip = &mut self.tips[t];
            if tip.implicit_force.is_some() {
                tip.implicit_force = Some(force);
            }
            let (velocity, wanted) = (tip.velocity, response.velocity(force));
            let Some(next) = self.motions[t].next(velocity, wanted, sheet, tip.length_scale(), &response) else {
                continue;
            };
            tip.position += self.dt * (next - velocity);
            (tip.velocity, tip.implicit_force) = (next, Some(force));
            changed = true;
            for at in 0..self.contacts.len() {
                let contact = self.contacts[at];
                if holds(&&contact) {
                    let x = (trial.start)(system, contact.node as usize);
                    let (towards, target) = self.towards(t, x, contact.normal);
                    let rebound = contact.rebound;
                    self.contacts[at].target[0] = if rebound > 0.0 { target.max(towards + rebound) } else { target };
                    self.constrain(&self.contacts[at], x, system);
                }
            }
        }
        changed
    }

    /// The contact of a vertex with tip `t` at the unit outward `normal`.
    fn new_contact(&self, t: usize, node: u32, vertex: Vertex, normal: Vec3) -> VertexContact {
        let Vertex { x, v } = vertex;
        let (tip, before) = (&self.tips[t], self.previous.of(node));
        let (towards, target) = self.towards(t, x, normal);
        let speed = towards - v.dot(&normal);
        let rebound = if before.is_none() && speed > MIN_REBOUND_SPEED { tip.restitution * speed } else { 0.0 };
        let caught = before.is_none() && goes_far(tip, vertex, self.dt);
        let starts_sliding = match before {
            None => !caught && starts_sliding(tip, vertex, normal, target),
            Some(last) => last.friction.is_some(),
        };
        VertexContact {
            node,
            touched: Touched::one(t),
            normal,
            other: Vec3::zeros(),
            target: [if rebound > 0.0 { target.max(towards + rebound) } else { target }, 0.0],
            rebound,
            state: if starts_sliding { State::Slides } else { State::Sticks },
            stuck_before: before.is_some() && !starts_sliding,
            caught,
            friction: before.and_then(|last| last.friction).map_or(Vec3::zeros(), |f| f - f.dot(&normal) * normal),
            returned: false,
        }
    }

    /// Continuous collision detection: constrains vertices that would pass through a tip in this step with the velocities of a trial step.
    /// Returns whether there are any.
    fn add_swept_contacts(&mut self, system: &mut System, trial: &TrialStep<'_>) -> bool {
        let known = self.contacts.len();
        for t in 0..self.tips.len() {
            for at in 0..self.near[t].list.len() * usize::from(self.tips[t].constrains) {
                let (node, tip) = (self.near[t].list[at], &self.tips[t]);
                let vertex =
                    Vertex { x: (trial.start)(system, node as usize), v: (trial.velocity)(system, node as usize) };
                if !goes_far(tip, vertex, self.dt)
                    || !system.nodes.constraint[node as usize].is_free()
                    || self.contacts.iter().any(|h| h.node == node)
                {
                    continue;
                }
                if let Some(normal) = contact_normal(tip, vertex, self.dt, None) {
                    let one = self.new_contact(t, node, vertex, normal);
                    self.constrain(&one, vertex.x, system);
                    self.contacts.push(one);
                }
            }
        }
        let caught = self.contacts.len() > known;
        if caught {
            self.contacts.sort_by_key(|contact| contact.node);
        }
        caught
    }

    /// Sets the constraint and the prescribed velocity of a vertex from its contact state. `x` is its position before
    /// the step, m.
    fn constrain(&self, contact: &VertexContact, x: Vec3, system: &mut System) {
        let (i, n, nodes) = (contact.node as usize, contact.normal, &mut system.nodes);
        let drive = self.tips[contact.touched.first].velocity_at(x);
        let Some(second) = contact.touched.second else {
            (nodes.constraint[i], nodes.prescribed[i]) = match contact.state {
                State::Free => (Constraint::Free, Vec3::zeros()),
                State::Slides => (Constraint::Plane(n), contact.target[0] * n),
                State::Sticks => (Constraint::Fixed, drive + (contact.target[0] - drive.dot(&n)) * n),
            };
            return;
        };
        let other = self.tips[second].velocity_at(x);
        let along = n.cross(&contact.other);
        if contact.state == State::Free {
            (nodes.constraint[i], nodes.prescribed[i]) = (Constraint::Free, Vec3::zeros());
        } else if along.norm() > PARALLEL {
            // The velocity in the plane of the two normals follows from both normal velocities by their 2 x 2 Gram matrix.
            let (c, [a, b]) = (n.dot(&contact.other), contact.target);
            let determinant = 1.0 - c * c;
            let (p, q) = ((a - c * b) / determinant, (b - c * a) / determinant);
            let velocity = p * n + q * contact.other;
            let line = along.normalize();
            let mean = 0.5 * (drive.dot(&line) + other.dot(&line));
            (nodes.constraint[i], nodes.prescribed[i]) = match contact.state {
                State::Slides => (Constraint::Line(line), velocity),
                State::Sticks | State::Free => (Constraint::Fixed, velocity + mean * line),
            };
        } else {
            // Parallel normals leave one direction: pushed from one side the vertex follows the deeper tip, pinched it follows the mean.
            let mean = 0.5 * (drive + other);
            let [a, b] = contact.target;
            let target = if n.dot(&contact.other) > 0.0 { a.max(b) } else { 0.5 * (a - b) };
            (nodes.constraint[i], nodes.prescribed[i]) = match contact.state {
                State::Slides => (Constraint::Plane(n), target * n),
                State::Sticks | State::Free => (Constraint::Fixed, mean + (target - mean.dot(&n)) * n),
            };
        }
    }
}

impl ContactConstraints for SheetTips {
    fn begin(&mut self, system: &mut System, dt: f64) {
        self.dt = dt;
        self.passes = 0;
        self.motions.clear();
        self.update_near(&system.nodes.x, dt);
        self.contacts.clear();
        for t in 0..self.tips.len() {
            for at in 0..self.near[t].list.len() * usize::from(self.tips[t].constrains) {
                let node = self.near[t].list[at];
                if !system.nodes.constraint[node as usize].is_free() {
                    continue; // a fixing takes precedence
                }
                let vertex = Vertex { x: system.nodes.x[node as usize], v: system.nodes.v[node as usize] };
                let before = self.previous.of(node);
                let gap = before.map(|last| self.gap(t, last));
                let Some(normal) = contact_normal(&self.tips[t], vertex, dt, gap) else { continue };
                let one = self.new_contact(t, node, vertex, normal);
                match self.contacts.iter_mut().find(|contact| contact.node == node) {
                    Some(contact) => {
                        (contact.touched.second, contact.other, contact.target[1]) = (Some(t), normal, one.target[0]);
                        // A pinched vertex has no transition from sliding to sticking, so it begins by sticking.
                        if before.is_none_or(|last| last.touched.second.is_none()) {
                            (contact.state, contact.friction) = (State::Sticks, Vec3::zeros());
                        }
                    }
                    None => self.contacts.push(one),
                }
            }
        }
        self.contacts.sort_by_key(|contact| contact.node);
        for contact in &self.contacts {
            self.constrain(contact, system.nodes.x[contact.node as usize], system);
        }
    }

    fn add_forces(&self, force: &mut [Vec3]) {
        for contact in self.contacts.iter().filter(|contact| contact.state == State::Slides) {
            force[contact.node as usize] += contact.friction;
        }
    }

    fn update_active_set(&mut self, system: &mut System, trial: &TrialStep<'_>) -> bool {
        let is_whole = trial.error_bound.is_none();
        // While a velocity is searched for, contacts stay, and where tips have a mass there may be more solves than contacts are judged after.
        let searches = self.motions.iter().any(TipMotion::is_searching);
        if searches && is_whole && self.solve_tip_velocities(system, trial) {
            return true;
        }
        self.passes += usize::from(is_whole);
        if self.passes > MAX_ACTIVE_SET_PASSES {
            return !searches && is_whole && self.solve_tip_velocities(system, trial);
        }
        let mut changed = trial.error_bound.is_none() && self.add_swept_contacts(system, trial);
        let mut tips = std::mem::take(&mut self.contacts);
        for contact in &mut tips {
            if let Some((next, true)) = self.transition(contact, system, trial) {
                *contact = next;
                let x = (trial.start)(system, contact.node as usize);
                self.constrain(contact, x, system);
                changed = true;
            }
        }
        self.contacts = tips;
        // A velocity is found for the forces of contacts that stay as they are.
        changed || (!searches && is_whole && self.solve_tip_velocities(system, trial))
    }

    fn can_stop_early(&self, system: &System, trial: &TrialStep<'_>) -> bool {
        self.motions.iter().all(|motion| motion.tried == 0)
            && is_settled(self.contacts.iter().map(|contact| self.transition(contact, system, trial)))
    }

    fn interrupts_history(&self) -> bool {
        // The tip's step is one of backward Euler, and so is that of what it may meet.
        let mut each = self.tips.iter().zip(&self.near);
        self.is_active() || each.any(|(tip, near)| tip.response.is_some() && tip.constrains && !near.list.is_empty())
    }

    fn begin_iteration(&mut self) {
        self.motions.clear();
        self.motions.resize(self.tips.len(), TipMotion::default());
        self.passes = 0;
    }

    fn max_passes(&self) -> usize {
        let with_mass = self.tips.iter().filter(|tip| tip.response.is_some()).count();
        MAX_ACTIVE_SET_PASSES + MOST_TRIED * with_mass
    }

    fn has_candidates(&self) -> bool {
        self.near.iter().zip(&self.tips).any(|(near, tip)| tip.constrains && !near.list.is_empty())
    }

    fn is_active(&self) -> bool {
        self.is_pressed || !self.contacts.is_empty()
    }

    fn keep_start(&mut self) {
        self.previous.keep_start();
        // They may name nodes that are others by now.
        self.contacts.clear();
    }

    fn take_back(&mut self, system: &mut System) {
        self.previous.restore_start();
        for contact in self.contacts.drain(..) {
            system.nodes.release(contact.node);
        }
    }

    fn end(&mut self, system: &mut System, reaction: &mut [Vec3]) {
        self.friction_work = 0.0;
        for tip in &mut self.tips {
            (tip.force, tip.constrained) = (Vec3::zeros(), 0);
        }
        self.presses.iter_mut().for_each(Vec::clear);
        self.previous.clear();
        for at in 0..self.contacts.len() {
            let contact = &self.contacts[at];
            let i = contact.node as usize;
            if contact.state != State::Free {
                let on_node = reaction[i] + contact.friction;
                // The force on a pinched vertex is divided between the tips in proportion to the normal force of each.
                let fractions = match contact.touched.second {
                    None => [1.0, 0.0],
                    Some(_) => {
                        let [a, b] = [contact.normal, contact.other].map(|n| on_node.dot(&n).max(0.0));
                        if a + b > 0.0 { [a / (a + b), b / (a + b)] } else { [0.5, 0.5] }
                    }
                };
                for (t, fraction) in [Some(contact.touched.first), contact.touched.second].into_iter().zip(fractions) {
                    let Some(tip) = t.map(|t| &mut self.tips[t]) else { continue };
                    tip.force -= fraction * on_node;
                    tip.constrained += 1;
                }
                if let Some(presses) = &mut self.presses {
                    let both = [
                        Some((contact.touched.first, contact.normal)),
                        contact.touched.second.map(|t| (t, contact.other)),
                    ];
                    for ((tip, direction), fraction) in both.into_iter().flatten().zip(fractions) {
                        let past = system.nodes.v[i] - self.tips[tip].velocity_at(system.nodes.x[i]);
                        let slip = past - past.dot(&direction) * direction;
                        let force = (fraction * on_node.dot(&direction)).max(0.0);
                        presses.push(Press { tip, direction, force, slip });
                    }
                }
                let slides = contact.state == State::Slides;
                let tip = &self.tips[contact.touched.first];
                let next_friction = || {
                    let slip = system.nodes.v[i] - tip.velocity_at(system.nodes.x[i]);
                    contact.next_friction(tip.friction, reaction[i], slip, system.nodes.mass[i], self.dt)
                };
                let friction = slides.then(next_friction).flatten();
                self.previous.add(PreviousContact { node: contact.node, touched: contact.touched, friction });
            }
            if contact.state != State::Free && contact.touched.second.is_none() {
                // The velocity that moved it out of the tip was a correction of its position; it is removed again.
                let (n, tip) = (contact.normal, &mut self.tips[contact.touched.first]);
                let excess =
                    ((system.nodes.v[i] - tip.velocity_at(system.nodes.x[i])).dot(&n) - contact.rebound).max(0.0);
                system.nodes.v[i] -= excess * n;
                let push = system.nodes.mass[i] * excess / self.dt;
                tip.force += push * n;
                reaction[i] -= push * n;
            }
            if contact.state == State::Slides {
                let slip = system.nodes.v[i] - self.tips[contact.touched.first].velocity_at(system.nodes.x[i]);
                self.friction_work -= contact.friction.dot(&slip) * self.dt;
                reaction[i] += contact.friction;
            }
            system.nodes.release(contact.node);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Friction;
    use crate::shape::OrientedShape;

    fn tip(sliding: f64) -> Tip {
        let friction = Friction { static_coefficient: sliding, kinetic_coefficient: sliding };
        let still = Vec3::zeros();
        Tip {
            position: still,
            velocity: still,
            spin: still,
            shape: OrientedShape::sphere(8e-3),
            friction,
            restitution: 0.0,
            constrains: true,
            response: None,
            implicit_force: None,
            force: still,
            constrained: 0,
        }
    }

    #[test]
    fn a_vertex_follows_a_receding_tip_but_not_after_a_pinch() {
        let sheet = SheetTips { tips: vec![tip(0.3), tip(0.3)], dt: 1e-3, ..SheetTips::default() };
        let gap = |t: usize, touched: Touched| sheet.gap(t, PreviousContact { node: 0, touched, friction: None });
        let (first, both) = (Touched::one(0), Touched { first: 0, second: Some(1) });
        assert_eq!((gap(0, first), gap(1, first), gap(0, both)), (0.5e-3, 8e-6, 8e-6));
        let outside = |gap| {
            contact_normal(&sheet.tips[0], Vertex { x: Vec3::new(0.0, 0.0, 8.4e-3), v: Vec3::zeros() }, 1e-3, gap)
                .is_some()
        };
        assert!(outside(Some(gap(0, first))) && !outside(Some(gap(1, first))) && !outside(None));
    }

    #[test]
    fn a_new_contact_slides_if_friction_cannot_stop_it() {
        let normal = Vec3::z();
        let slides = |sliding: f64, v: Vec3| starts_sliding(&tip(sliding), Vertex { x: Vec3::zeros(), v }, normal, 0.0);
        assert!(
            !slides(0.3, Vec3::new(0.02, 0.0, -0.1)) && slides(0.3, Vec3::new(0.04, 0.0, -0.1)),
            "the normal velocity changes by 0.1 m/s, so friction stops 0.03 m/s"
        );
        assert!(slides(0.0, Vec3::new(1e-6, 0.0, -0.1)) && !slides(0.0, Vec3::new(0.0, 0.0, -0.1)));
    }
}
