//! Tips on the vertices of a sheet, as contact constraints.
//!
//! A vertex inside a tip is constrained to its surface for the step: it sticks, and the solver finds the constraint force. One that would
//! have to be pulled is released; one that would need more than friction gives slides, with the friction of Coulomb (1785) as a
//! force and its normal motion still held (Tripicchio, D'Avella and Ruffaldi 2022, with the reaction of the unfiltered system
//! in the place of their work). Sticking is tried before sliding; one that slid in the last step goes on sliding with the friction of that
//! step, and sticks where that would move it. One that comes to a tip past which it slips slides at once: stuck in a taut sheet it would be
//! pulled at, and let into the tip.

use super::fingertip::{Press, SWEEP, Tip, Vertex, goes_far, meets, slips};
use super::held::{Held, State, is_settled};
use super::reach::Reach;
use pliant_solver::{Constraint, ContactConstraints, System, TrialStep, Vec3};

/// The tips on one sheet.
#[derive(Default)]
pub struct SheetTips {
    /// Where each vertex of the last step pressed, if someone wants to know.
    pub presses: Option<Vec<Press>>,
    /// In the order of the tools.
    pub tips: Vec<Tip>,
    /// How far a vertex may have moved since the last step, m.
    pub moved: f64,
    /// What friction took in the last step, J.
    pub friction_work: f64,
    near: Vec<Reach>,
    held: Vec<Held>,
    /// Length of the step, s.
    dt: f64,
    /// Vertices held in the last step, rising.
    before: Vec<Last>,
}

/// What a vertex did in the last step.
#[derive(Clone, Copy)]
struct Last {
    node: u32,
    tips: (usize, Option<usize>),
    /// N, if it slides on.
    friction: Option<Vec3>,
}

/// How fast a vertex is pushed out at most, besides the motion of the tip, m/s.
const CORRECTION: f64 = 0.5;
/// Radii: how far off a vertex may be that two tips held, or another one.
const NEAR: f64 = 1e-3;
/// Normals less apart than this, as the sine, count as one line.
const PARALLEL: f64 = 0.02;
/// m/s, slower than this a vertex does not leave a tip again by itself.
const RESTS: f64 = 0.02;

impl SheetTips {
    /// The nodes of the body have changed.
    pub fn forget(&mut self) {
        self.near.iter_mut().for_each(Reach::forget);
        self.before.clear();
    }

    fn list(&mut self, x: &[Vec3], dt: f64) {
        self.near.resize_with(self.tips.len(), Reach::default);
        for (near, tip) in self.near.iter_mut().zip(&self.tips).filter(|(_, tip)| tip.holds) {
            let travel = dt * tip.velocity.norm();
            let Some(reach) = near.renew(tip.position, tip.shape.shape(), self.moved, travel) else { continue };
            let within = |i: &u32| (x[*i as usize] - tip.position).norm_squared() <= reach * reach;
            near.list.extend((0..x.len() as u32).filter(within));
        }
    }

    /// What a vertex did in the last step, if it was held.
    fn before(&self, node: u32) -> Option<Last> {
        self.before.binary_search_by_key(&node, |last| last.node).ok().map(|at| self.before[at])
    }

    /// m, how far from a tip a vertex may be that was held in the last step. It follows a tip that draws back, while it goes on being
    /// pushed; where two tips let go of it, or it comes to another, it does not.
    fn gap(&self, t: usize, last: Last) -> f64 {
        let scale = self.tips[t].length_scale();
        if last.tips == (t, None) { (CORRECTION * self.dt).min(SWEEP * scale) } else { NEAR * scale }
    }

    /// N, on a vertex that slides on, by the force it is held with now; none if it would speed it up: then it sticks. It turns
    /// into the slip no faster than the vertex's own inertia has it: a light vertex of a taut sheet would else be thrown to and
    /// fro across its way.
    fn next_friction(&self, held: &Held, system: &System, reaction: Vec3) -> Option<Vec3> {
        let tip = &self.tips[held.tips.0];
        let i = held.node as usize;
        let slip = system.nodes.v[i] - tip.velocity_at(system.nodes.x[i]);
        let slip = slip - slip.dot(&held.normal) * held.normal;
        let (speed, push) = (slip.norm(), reaction.dot(&held.normal).max(0.0));
        if slip.dot(&held.friction) > 0.0 || speed == 0.0 {
            return None;
        }
        let (most, size) = (tip.friction.sliding * push, held.friction.norm());
        let turned = if size > 0.0 { most / size * held.friction } else { Vec3::zeros() };
        let turned = turned - system.nodes.mass[held.node as usize] / self.dt * slip;
        Some(most / turned.norm() * turned)
    }

    /// A vertex at `x` that moves with `v` and meets a tip at `normal`.
    fn touch(&self, t: usize, node: u32, vertex: Vertex, normal: Vec3) -> Held {
        let Vertex { x, v } = vertex;
        let (tip, before) = (&self.tips[t], self.before(node));
        let towards = tip.velocity_at(x).dot(&normal);
        let target = (tip.depth(x, normal) / self.dt).min(towards.max(0.0) + CORRECTION);
        let speed = towards - v.dot(&normal);
        let rebound = if before.is_none() && speed > RESTS { tip.restitution * speed } else { 0.0 };
        let caught = before.is_none() && goes_far(tip, vertex, self.dt);
        let slips = match before {
            None => !caught && slips(tip, vertex, normal, target),
            Some(last) => last.friction.is_some(),
        };
        Held {
            node,
            tips: (t, None),
            normal,
            other: Vec3::zeros(),
            target: [if rebound > 0.0 { target.max(towards + rebound) } else { target }, 0.0],
            rebound,
            state: if slips { State::Slides } else { State::Sticks },
            stuck_before: before.is_some() && !slips,
            caught,
            friction: before.and_then(|last| last.friction).map_or(Vec3::zeros(), |f| f - f.dot(&normal) * normal),
            returned: false,
        }
    }

    /// Constrains vertices that would come to the far side of a tip in this step, moving as `after` says.
    fn catch(&mut self, system: &mut System, after: &dyn Fn(&System, usize) -> Vec3) -> bool {
        let known = self.held.len();
        for t in 0..self.tips.len() {
            for at in 0..self.near[t].list.len() * usize::from(self.tips[t].holds) {
                let (node, tip) = (self.near[t].list[at], &self.tips[t]);
                let vertex = Vertex { x: system.nodes.x[node as usize], v: after(system, node as usize) };
                if !goes_far(tip, vertex, self.dt)
                    || !system.nodes.constraint[node as usize].is_free()
                    || self.held.iter().any(|h| h.node == node)
                {
                    continue;
                }
                if let Some(normal) = meets(tip, vertex, self.dt, None) {
                    let one = self.touch(t, node, vertex, normal);
                    self.hold(&one, system);
                    self.held.push(one);
                }
            }
        }
        let caught = self.held.len() > known;
        if caught {
            self.held.sort_by_key(|held| held.node);
        }
        caught
    }

    fn hold(&self, held: &Held, system: &mut System) {
        let i = held.node as usize;
        let nodes = &mut system.nodes;
        let (n, x) = (held.normal, nodes.x[i]);
        let drive = self.tips[held.tips.0].velocity_at(x);
        let Some(second) = held.tips.1 else {
            (nodes.constraint[i], nodes.prescribed[i]) = match held.state {
                State::Free => (Constraint::Free, Vec3::zeros()),
                State::Slides => (Constraint::Plane(n), held.target[0] * n),
                State::Sticks => (Constraint::Fixed, drive + (held.target[0] - drive.dot(&n)) * n),
            };
            return;
        };
        let other = self.tips[second].velocity_at(x);
        let along = n.cross(&held.other);
        if held.state == State::Free {
            (nodes.constraint[i], nodes.prescribed[i]) = (Constraint::Free, Vec3::zeros());
        } else if along.norm() > PARALLEL {
            // Both normal velocities: in the plane of the normals, from their 2 x 2 Gram system.
            let (c, [a, b]) = (n.dot(&held.other), held.target);
            let determinant = 1.0 - c * c;
            let (p, q) = ((a - c * b) / determinant, (b - c * a) / determinant);
            let velocity = p * n + q * held.other;
            let line = along.normalize();
            let mean = 0.5 * (drive.dot(&line) + other.dot(&line));
            (nodes.constraint[i], nodes.prescribed[i]) = match held.state {
                State::Slides => (Constraint::Line(line), velocity),
                _ => (Constraint::Fixed, velocity + mean * line),
            };
        } else {
            // Only one direction is left: pushed from one side it goes with the deeper tip, pinched it goes midway.
            let mean = 0.5 * (drive + other);
            let [a, b] = held.target;
            let target = if n.dot(&held.other) > 0.0 { a.max(b) } else { 0.5 * (a - b) };
            (nodes.constraint[i], nodes.prescribed[i]) = match held.state {
                State::Slides => (Constraint::Plane(n), target * n),
                _ => (Constraint::Fixed, mean + (target - mean.dot(&n)) * n),
            };
        }
    }
}

impl ContactConstraints for SheetTips {
    fn begin(&mut self, system: &mut System, dt: f64) {
        self.dt = dt;
        self.list(&system.nodes.x, dt);
        self.held.clear();
        for t in 0..self.tips.len() {
            for at in 0..self.near[t].list.len() * usize::from(self.tips[t].holds) {
                let node = self.near[t].list[at];
                if !system.nodes.constraint[node as usize].is_free() {
                    continue; // what is fixed stays so
                }
                let vertex = Vertex { x: system.nodes.x[node as usize], v: system.nodes.v[node as usize] };
                let before = self.before(node);
                let gap = before.map(|last| self.gap(t, last));
                let Some(normal) = meets(&self.tips[t], vertex, dt, gap) else { continue };
                let one = self.touch(t, node, vertex, normal);
                match self.held.iter_mut().find(|held| held.node == node) {
                    Some(held) => {
                        (held.tips.1, held.other, held.target[1]) = (Some(t), normal, one.target[0]);
                        // A pinch does not turn from sliding to sticking, so it begins with that.
                        if before.is_none_or(|last| last.tips.1.is_none()) {
                            (held.state, held.friction) = (State::Sticks, Vec3::zeros());
                        }
                    }
                    None => self.held.push(one),
                }
            }
        }
        self.held.sort_by_key(|held| held.node);
        for held in &self.held {
            self.hold(held, system);
        }
    }

    fn add_forces(&self, force: &mut [Vec3]) {
        for held in self.held.iter().filter(|held| held.state == State::Slides) {
            force[held.node as usize] += held.friction;
        }
    }

    fn update_active_set(&mut self, system: &mut System, trial: &TrialStep<'_>) -> bool {
        let mut changed = trial.error_bound.is_none() && self.catch(system, trial.velocity);
        let mut all = std::mem::take(&mut self.held);
        for held in &mut all {
            if let Some((next, true)) = held.judge(&self.tips[held.tips.0], system, trial) {
                *held = next;
                self.hold(held, system);
                changed = true;
            }
        }
        self.held = all;
        changed
    }

    fn can_stop_early(&self, system: &System, trial: &TrialStep<'_>) -> bool {
        is_settled(self.held.iter().map(|held| held.judge(&self.tips[held.tips.0], system, trial)))
    }

    fn has_candidates(&self) -> bool {
        self.near.iter().zip(&self.tips).any(|(near, tip)| tip.holds && !near.list.is_empty())
    }

    fn is_active(&self) -> bool {
        !self.held.is_empty()
    }

    fn end(&mut self, system: &mut System, reaction: &mut [Vec3]) {
        self.friction_work = 0.0;
        for tip in &mut self.tips {
            (tip.force, tip.held) = (Vec3::zeros(), 0);
        }
        self.presses.iter_mut().for_each(Vec::clear);
        self.before.clear();
        for at in 0..self.held.len() {
            let held = &self.held[at];
            let i = held.node as usize;
            if held.state != State::Free {
                let on_node = reaction[i] + held.friction;
                // What two tips do together is shared by how far each pushes along its own normal.
                let shares = match held.tips.1 {
                    None => [1.0, 0.0],
                    Some(_) => {
                        let [a, b] = [held.normal, held.other].map(|n| on_node.dot(&n).max(0.0));
                        if a + b > 0.0 { [a / (a + b), b / (a + b)] } else { [0.5, 0.5] }
                    }
                };
                for (t, share) in [Some(held.tips.0), held.tips.1].into_iter().zip(shares) {
                    let Some(tip) = t.map(|t| &mut self.tips[t]) else { continue };
                    tip.force -= share * on_node;
                    tip.held += 1;
                }
                if let Some(presses) = &mut self.presses {
                    let both = [Some((held.tips.0, held.normal)), held.tips.1.map(|t| (t, held.other))];
                    for ((tip, direction), share) in both.into_iter().flatten().zip(shares) {
                        let past = system.nodes.v[i] - self.tips[tip].velocity_at(system.nodes.x[i]);
                        let slip = past - past.dot(&direction) * direction;
                        presses.push(Press { tip, direction, size: (share * on_node.dot(&direction)).max(0.0), slip });
                    }
                }
                let slides = held.state == State::Slides;
                let friction = slides.then(|| self.next_friction(held, system, reaction[i])).flatten();
                self.before.push(Last { node: held.node, tips: held.tips, friction });
            }
            if held.state != State::Free && held.tips.1.is_none() {
                // What moved it out of the tip was a correction of its place; it leaves no velocity behind.
                let (n, tip) = (held.normal, &mut self.tips[held.tips.0]);
                let excess = ((system.nodes.v[i] - tip.velocity_at(system.nodes.x[i])).dot(&n) - held.rebound).max(0.0);
                system.nodes.v[i] -= excess * n;
                let push = system.nodes.mass[i] * excess / self.dt;
                tip.force += push * n;
                reaction[i] -= push * n;
            }
            if held.state == State::Slides {
                let slip = system.nodes.v[i] - self.tips[held.tips.0].velocity_at(system.nodes.x[i]);
                self.friction_work -= held.friction.dot(&slip) * self.dt;
                reaction[i] += held.friction;
            }
            system.nodes.constraint[i] = Constraint::Free;
            system.nodes.prescribed[i] = Vec3::zeros();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Friction;
    use crate::shape::OrientedShape;

    fn tip(sliding: f64) -> Tip {
        let friction = Friction { fixed: sliding, sliding };
        let still = Vec3::zeros();
        Tip {
            position: still,
            velocity: still,
            spin: still,
            shape: OrientedShape::sphere(8e-3),
            friction,
            restitution: 0.0,
            holds: true,
            force: still,
            held: 0,
        }
    }

    #[test]
    fn what_one_tip_held_follows_it_and_what_two_held_does_not() {
        let all = SheetTips { tips: vec![tip(0.3), tip(0.3)], dt: 1e-3, ..SheetTips::default() };
        let gap = |t: usize, tips: (usize, Option<usize>)| all.gap(t, Last { node: 0, tips, friction: None });
        assert_eq!((gap(0, (0, None)), gap(1, (0, None)), gap(0, (0, Some(1)))), (0.5e-3, 8e-6, 8e-6));
        let outside =
            |gap| meets(&all.tips[0], Vertex { x: Vec3::new(0.0, 0.0, 8.4e-3), v: Vec3::zeros() }, 1e-3, gap).is_some();
        assert!(outside(Some(gap(0, (0, None)))) && !outside(Some(gap(1, (0, None)))) && !outside(None));
    }

    #[test]
    fn what_comes_to_a_tip_slides_where_it_slips_more_than_friction_ends() {
        let normal = Vec3::z();
        let slides = |sliding: f64, v: Vec3| slips(&tip(sliding), Vertex { x: Vec3::zeros(), v }, normal, 0.0);
        assert!(
            !slides(0.3, Vec3::new(0.02, 0.0, -0.1)) && slides(0.3, Vec3::new(0.04, 0.0, -0.1)),
            "a tenth is turned, 0.3 of it ends"
        );
        assert!(slides(0.0, Vec3::new(1e-6, 0.0, -0.1)) && !slides(0.0, Vec3::new(0.0, 0.0, -0.1)));
    }
}
