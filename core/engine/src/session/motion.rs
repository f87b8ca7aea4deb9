//! How the bodies of a session move: their integrators and step limits, the threads that step them, which of them sleep, and how stiff they are.

use super::sleep::Sleep;
use super::step_limits::StepLimits;
use super::step_loads::StepLoads;
use super::stiffness::StiffnessState;
use super::workers::Workers;
use crate::body::Body;
use pliant_plugin_api::abi::Ball;
use pliant_solver::{Integrator, Pool, Vec3};

/// What the session keeps of its bodies to move them. Lists have an element for each moving body.
pub(super) struct Motion {
    /// Threads that step bodies.
    pub(super) workers: Workers,
    /// Scheme, and limits of its steps.
    pub(super) limits: StepLimits,
    /// Integrator of each body.
    pub(super) integrators: Vec<Integrator>,
    /// Which bodies sleep.
    pub(super) sleep: Sleep,
    /// Largest displacement of a node of each body in the last step, m.
    pub(super) moved: Vec<f64>,
    /// Loads on the body that is being stepped.
    pub(super) loads: StepLoads,
    /// Balls of cells that tools need of a body; a buffer.
    pub(super) balls: Vec<Ball>,
    /// Points of a body that tools grip, m; a buffer.
    pub(super) grips: Vec<Vec3>,
    /// Stiffness of all bodies relative to that of the scene.
    pub(super) stiffness: StiffnessState,
}

impl Motion {
    /// Bodies at rest, before integrators are chosen.
    pub(super) fn new(workers: Workers, limits: StepLimits, sleep: Sleep, loads: StepLoads, bodies: usize) -> Self {
        Self {
            workers,
            limits,
            integrators: Vec::new(),
            sleep,
            moved: vec![0.0; bodies],
            loads,
            balls: Vec::new(),
            grips: Vec::new(),
            stiffness: StiffnessState::default(),
        }
    }

    /// The pool of all threads.
    pub(super) fn pool(&self) -> &Pool {
        &self.workers.all
    }

    /// Whether the scheme of the bodies is implicit.
    pub(super) fn is_implicit(&self) -> bool {
        self.limits.scheme.is_implicit()
    }

    /// Whether nothing moves body number `index`: it is in quarantine, or it sleeps.
    pub(super) fn stands(&self, index: usize, body: &Body) -> bool {
        body.frozen.is_some() || self.sleep.is_asleep(index)
    }

    /// Wakes each of two bodies that meet if it sleeps and the other one moves, in steps of `dt` (s).
    pub(super) fn wake_each_other(&mut self, [i, j]: [usize; 2], dt: f64) {
        let moves = |b: usize| !self.sleep.is_asleep(b) && self.moved[b] >= self.sleep.speed() * dt;
        let [wakes_i, wakes_j] = [moves(j), moves(i)];
        for (b, wakes) in [(i, wakes_i), (j, wakes_j)] {
            if wakes && self.sleep.is_asleep(b) {
                self.sleep.wake(b);
            }
        }
    }

    /// Forgets what follows from the nodes of a body, after a change of them, and wakes it.
    pub(super) fn changed(&mut self, index: usize, body: &Body) {
        self.integrators[index].resize(body.system.nodes.len());
        self.integrators[index].in_contact = false;
        self.sleep.wake(index);
    }

    /// Adapts to other bodies, of which each is a part of the body of the scene in `roots`, or that body. Those before number `kept` are as they were; a part is
    /// moved as the whole was.
    pub(super) fn set_bodies(&mut self, bodies: &[Body], roots: &[usize], kept: usize) {
        self.integrators.truncate(kept);
        self.limits.truncate(kept);
        for (body, &root) in bodies.iter().zip(roots).skip(kept) {
            let mut integrator = self.integrators[root].with_same_settings();
            integrator.resize(body.system.nodes.len());
            self.integrators.push(integrator);
            self.limits.push_like(root, &body.name);
        }
        self.moved.resize(bodies.len(), 0.0);
        self.workers.resize(bodies.len());
        self.sleep.resize(bodies.len());
    }

    /// Records the velocities that contact has left a body with at the end of a step of `dt` (s).
    pub(super) fn record_velocities(&mut self, index: usize, v: &[Vec3], dt: f64) {
        self.moved[index] = dt * v.iter().fold(0.0, |most: f64, v| most.max(v.norm_squared())).sqrt();
    }

    /// Constraint forces on each node of a body in the last step, N (n x 3).
    pub(super) fn reactions(&self, body: usize) -> &[Vec3] {
        self.integrators.get(body).map_or(&[], |integrator| &integrator.reaction)
    }

    /// Memory of the integrators at present, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.integrators.iter().map(Integrator::bytes).sum()
    }
}
