//! Sphere fingertips on the vertices of a sheet, as constraints.
//!
//! A vertex inside a tip is held on its surface for the step: it sticks, and the solver says what that takes. One that would
//! have to be pulled is let go; one that would take more than friction gives slides, with the friction of Coulomb (1785) as a
//! force and its normal motion still held (Tripicchio, D'Avella and Ruffaldi 2022, with the reaction of the unfiltered system
//! in the place of their work). Sticking is tried first; one that slid in the last step goes on sliding with the friction of that
//! step, until that would speed it up.

use super::proxy::Friction;
use crate::step::{Constraint, Holds, System, V3, axpy, dot};
use nalgebra::Vector3;

/// A fingertip at the end of a step.
#[derive(Clone, Copy, Debug)]
pub struct Tip {
    /// m, centre
    pub position: V3,
    /// m/s
    pub velocity: V3,
    /// m
    pub radius: f64,
    /// On the sheet.
    pub friction: Friction,
    /// N, what the last step did to it
    pub force: V3,
    /// Vertices it held in the last step.
    pub held: usize,
}

/// A place where a fingertip was pressed.
#[derive(Clone, Copy, Debug)]
pub struct Press {
    /// Which tip.
    pub tip: usize,
    /// From its centre, of unit length.
    pub direction: V3,
    /// N, along it
    pub size: f64,
    /// m/s, of the surface past the tip
    pub slip: V3,
}

/// The fingertips on one body.
#[derive(Default)]
pub struct Spheres {
    /// Where each vertex of the last step pressed, if someone wants to know.
    pub presses: Option<Vec<Press>>,
    /// In the order of the tools.
    pub tips: Vec<Tip>,
    /// m, how far a vertex may have moved since the last step
    pub moved: f64,
    near: Vec<NearTip>,
    held: Vec<Held>,
    /// Vertices held in the last step, rising, and their friction, N, if they slid.
    before: Vec<(u32, Option<V3>)>,
}

/// Vertices a tip may reach soon, and how much motion, m, the list still stands for.
#[derive(Default)]
struct NearTip {
    nodes: Vec<u32>,
    slack: f64,
    centre: V3,
}

/// A vertex that is held.
#[derive(Clone, Copy, Debug)]
struct Held {
    node: u32,
    /// First tip, and another one.
    tips: (usize, Option<usize>),
    normal: V3,
    /// The other tip's.
    other: V3,
    /// m/s, along the normals
    target: [f64; 2],
    state: State,
    stuck_before: bool,
    /// N, friction while it slides
    friction: V3,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Sticks,
    Slides,
    Free,
}

/// m/s, how fast a vertex is pushed out at most, besides the motion of the tip
const CORRECTION: f64 = 0.5;
/// Normals less apart than this, as the sine, count as one line.
const PARALLEL: f64 = 0.02;
/// Radii around a tip in which vertices are listed.
const MARGIN: f64 = 0.5;

impl Spheres {
    /// The nodes of the body have changed.
    pub fn forget(&mut self) {
        self.near.iter_mut().for_each(|near| near.slack = -1.0);
        self.before.clear();
    }

    fn list(&mut self, x: &[V3]) {
        self.near.resize_with(self.tips.len(), || NearTip { slack: -1.0, ..NearTip::default() });
        for (near, tip) in self.near.iter_mut().zip(&self.tips) {
            let shift = axpy(tip.position, -1.0, near.centre);
            near.slack -= self.moved + dot(shift, shift).sqrt();
            near.centre = tip.position;
            if near.slack >= 0.0 {
                continue;
            }
            near.slack = MARGIN * tip.radius;
            let reach = tip.radius + near.slack;
            let within = |i: &u32| {
                let d = axpy(x[*i as usize], -1.0, tip.position);
                dot(d, d) <= reach * reach
            };
            near.nodes.clear();
            near.nodes.extend((0..x.len() as u32).filter(within));
        }
    }

    /// What a vertex did in the last step, if it was held: the friction it slid with, or that it stuck.
    fn before(&self, node: u32) -> Option<Option<V3>> {
        self.before.binary_search_by_key(&node, |(n, _)| *n).ok().map(|at| self.before[at].1)
    }

    /// N, on a vertex that slides on, by the force it is held with now; none if it would speed it up: then it sticks.
    fn next_friction(&self, held: &Held, system: &System, reaction: V3) -> V3 {
        let tip = &self.tips[held.tips.0];
        let slip = axpy(system.nodes.v[held.node as usize], -1.0, tip.velocity);
        let slip = axpy(slip, -dot(slip, held.normal), held.normal);
        let (speed, push) = (dot(slip, slip).sqrt(), dot(reaction, held.normal).max(0.0));
        if dot(slip, held.friction) >= 0.0 || speed == 0.0 {
            return [0.0; 3];
        }
        slip.map(|c| -tip.friction.sliding * push / speed * c)
    }

    fn hold(&self, held: &Held, system: &mut System) {
        let i = held.node as usize;
        let nodes = &mut system.nodes;
        let (tip, n) = (&self.tips[held.tips.0], held.normal);
        let Some(second) = held.tips.1 else {
            (nodes.constraint[i], nodes.prescribed[i]) = match held.state {
                State::Free => (Constraint::Free, [0.0; 3]),
                State::Slides => (Constraint::Plane(n), n.map(|c| held.target[0] * c)),
                State::Sticks => (Constraint::Fixed, axpy(tip.velocity, held.target[0] - dot(tip.velocity, n), n)),
            };
            return;
        };
        let other = &self.tips[second];
        let along = Vector3::from(n).cross(&Vector3::from(held.other));
        if held.state == State::Free {
            (nodes.constraint[i], nodes.prescribed[i]) = (Constraint::Free, [0.0; 3]);
        } else if along.norm() > PARALLEL {
            // Both normal velocities: in the plane of the normals, from their 2 x 2 Gram system.
            let (c, [a, b]) = (dot(n, held.other), held.target);
            let determinant = 1.0 - c * c;
            let (p, q) = ((a - c * b) / determinant, (b - c * a) / determinant);
            let velocity = axpy(n.map(|x| p * x), q, held.other);
            let line: V3 = along.normalize().into();
            let mean = 0.5 * (dot(tip.velocity, line) + dot(other.velocity, line));
            (nodes.constraint[i], nodes.prescribed[i]) = match held.state {
                State::Slides => (Constraint::Line(line), velocity),
                _ => (Constraint::Fixed, axpy(velocity, mean, line)),
            };
        } else {
            // Pinched: only one direction is left, and the vertex goes midway.
            let mean = axpy(tip.velocity, 1.0, other.velocity).map(|c| 0.5 * c);
            let target = 0.5 * (held.target[0] + held.target[1] * dot(n, held.other).signum());
            (nodes.constraint[i], nodes.prescribed[i]) = match held.state {
                State::Slides => (Constraint::Plane(n), n.map(|c| target * c)),
                _ => (Constraint::Fixed, axpy(mean, target - dot(mean, n), n)),
            };
        }
    }
}

impl Holds for Spheres {
    fn begin(&mut self, system: &mut System, dt: f64) {
        self.list(&system.nodes.x);
        self.held.clear();
        for t in 0..self.tips.len() {
            let tip = self.tips[t];
            for at in 0..self.near[t].nodes.len() {
                let node = self.near[t].nodes[at];
                if !system.nodes.constraint[node as usize].is_free() {
                    continue; // what is fixed stays so
                }
                let d = Vector3::from(axpy(system.nodes.x[node as usize], -1.0, tip.position));
                let (distance, before) = (d.norm(), self.before(node));
                if distance > tip.radius * if before.is_some() { 1.0 + 1e-3 } else { 1.0 } {
                    continue;
                }
                let normal: V3 = d.try_normalize(1e-9).unwrap_or_else(Vector3::z).into();
                let most = dot(tip.velocity, normal).max(0.0) + CORRECTION;
                let target = ((tip.radius - distance) / dt).min(most);
                let one = Held {
                    node,
                    tips: (t, None),
                    normal,
                    other: [0.0; 3],
                    target: [target, 0.0],
                    state: if let Some(Some(_)) = before { State::Slides } else { State::Sticks },
                    stuck_before: before == Some(None),
                    friction: before.flatten().map_or([0.0; 3], |f| axpy(f, -dot(f, normal), normal)),
                };
                match self.held.iter_mut().find(|held| held.node == node) {
                    Some(held) => (held.tips.1, held.other, held.target[1]) = (Some(t), normal, target),
                    None => self.held.push(one),
                }
            }
        }
        self.held.sort_by_key(|held| held.node);
        for held in &self.held {
            self.hold(held, system);
        }
    }

    fn add_forces(&self, force: &mut [V3]) {
        for held in self.held.iter().filter(|held| held.state == State::Slides) {
            force[held.node as usize] = axpy(force[held.node as usize], 1.0, held.friction);
        }
    }

    fn revise(&mut self, system: &mut System, reaction: &[V3]) -> bool {
        let mut changed = false;
        let mut all = std::mem::take(&mut self.held);
        for held in all.iter_mut().filter(|held| held.state != State::Free) {
            let lambda = reaction[held.node as usize];
            // A pinch is pushed from both sides: it is held by whichever pushes.
            let pushes = held.tips.1.map_or(dot(lambda, held.normal), |_| {
                let (a, b) = (dot(lambda, held.normal), dot(lambda, held.other));
                if dot(held.normal, held.other) < 0.0 { a.abs().max(b.abs()) } else { a.max(b) }
            });
            let friction = self.tips[held.tips.0].friction;
            if pushes < 0.0 {
                held.state = State::Free;
                changed = true;
            } else if held.state == State::Sticks && held.tips.1.is_none() {
                let along = axpy(lambda, -pushes, held.normal);
                let size = dot(along, along).sqrt();
                let most = if held.stuck_before { friction.fixed } else { friction.sliding };
                if size > most * pushes {
                    held.state = State::Slides;
                    held.friction = along.map(|c| friction.sliding * pushes / size * c);
                    changed = true;
                } else {
                    continue;
                }
            } else {
                continue;
            }
            self.hold(held, system);
        }
        self.held = all;
        changed
    }

    fn is_holding(&self) -> bool {
        !self.held.is_empty()
    }

    fn end(&mut self, system: &mut System, reaction: &[V3]) {
        for tip in &mut self.tips {
            (tip.force, tip.held) = ([0.0; 3], 0);
        }
        self.presses.iter_mut().for_each(Vec::clear);
        self.before.clear();
        for at in 0..self.held.len() {
            let held = &self.held[at];
            let i = held.node as usize;
            if held.state != State::Free {
                let on_node = axpy(reaction[i], 1.0, held.friction);
                // What two tips do together is shared by how far each pushes along its own normal.
                let shares = match held.tips.1 {
                    None => [1.0, 0.0],
                    Some(_) => {
                        let [a, b] = [held.normal, held.other].map(|n| dot(on_node, n).max(0.0));
                        if a + b > 0.0 { [a / (a + b), b / (a + b)] } else { [0.5, 0.5] }
                    }
                };
                for (t, share) in [Some(held.tips.0), held.tips.1].into_iter().zip(shares) {
                    let Some(tip) = t.map(|t| &mut self.tips[t]) else { continue };
                    tip.force = axpy(tip.force, -share, on_node);
                    tip.held += 1;
                }
                if let Some(presses) = &mut self.presses {
                    let both = [Some((held.tips.0, held.normal)), held.tips.1.map(|t| (t, held.other))];
                    for ((tip, direction), share) in both.into_iter().flatten().zip(shares) {
                        let past = axpy(system.nodes.v[i], -1.0, self.tips[tip].velocity);
                        let slip = axpy(past, -dot(past, direction), direction);
                        presses.push(Press { tip, direction, size: (share * dot(on_node, direction)).max(0.0), slip });
                    }
                }
                let slid = (held.state == State::Slides).then(|| self.next_friction(held, system, reaction[i]));
                self.before.push((held.node, slid.filter(|friction| *friction != [0.0; 3])));
            }
            system.nodes.constraint[i] = Constraint::Free;
            system.nodes.prescribed[i] = [0.0; 3];
        }
    }
}
