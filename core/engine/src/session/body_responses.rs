//! Answers of the bodies of a session to contact impulses, after they have moved ([`Compliance`]).

use super::ToolSlot;
use super::motion::Motion;
use crate::body::Body;
use crate::contact::Compliance;
use pliant_solver::{CancelToken, Constraint, Loads, StepTime, Vec3};

/// The bodies of a session after they have moved, each with the matrix of its step.
pub(super) struct BodyResponses<'a> {
    bodies: &'a mut [Body],
    tools: &'a mut [ToolSlot],
    motion: &'a mut Motion,
    cancel: &'a CancelToken,
    time: StepTime,
    /// What each body answers with (n).
    states: &'a mut Vec<ResponseState>,
    /// Bodies whose matrix could not be assembled, and why.
    failed: Vec<(usize, String)>,
}

/// Matrix by which a body responds to impulses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ResponseState {
    /// The body has had no impulse in this step.
    Untouched,
    /// The matrix of its step.
    Matrix,
    /// The lumped masses alone.
    Masses,
}

impl<'a> BodyResponses<'a> {
    /// The bodies at the end of the step of `time`, with the tools that load them.
    pub(super) fn new(
        bodies: &'a mut [Body],
        tools: &'a mut [ToolSlot],
        motion: &'a mut Motion,
        cancel: &'a CancelToken,
        time: StepTime,
        states: &'a mut Vec<ResponseState>,
    ) -> Self {
        states.clear();
        states.resize(bodies.len(), ResponseState::Untouched);
        Self { bodies, tools, motion, cancel, time, states, failed: Vec::new() }
    }

    /// Adds the forces of constraints under the impulses to the reactions, and lets the solvers go on from their steps. Returns the bodies that have failed,
    /// and why.
    pub(super) fn end(self) -> Vec<(usize, String)> {
        for (integrator, state) in self.motion.integrators.iter_mut().zip(&*self.states) {
            if *state == ResponseState::Matrix {
                integrator.end_responses();
            }
        }
        self.failed
    }

    /// Prepares the matrix of a body.
    fn begin(&mut self, index: usize) -> ResponseState {
        if !self.motion.is_implicit() || self.bodies[index].frozen.is_some() {
            return ResponseState::Masses;
        }
        self.motion.loads.exchange(self.tools, index);
        let Motion { integrators, workers, loads, .. } = &mut *self.motion;
        let system = &mut self.bodies[index].system;
        let under = Loads { gravity: Vec3::zeros(), forces: &[], tools: loads.springs() };
        let pool = workers.pool(system.elements());
        let (integrator, time) = (&mut integrators[index], self.time);
        let begun = pool.install(|| integrator.begin_responses(pool, system, &under, time));
        loads.exchange(self.tools, index);
        match begun {
            Ok(()) => ResponseState::Matrix,
            Err(error) => {
                self.failed.push((index, error.to_string()));
                ResponseState::Masses
            }
        }
    }
}

impl Compliance for BodyResponses<'_> {
    fn respond(
        &mut self,
        body: usize,
        constraints: &[Constraint],
        impulses: &[Vec3],
        tolerance: f64,
        changes: &mut [Vec3],
    ) -> Option<usize> {
        if self.states[body] == ResponseState::Untouched {
            self.states[body] = self.begin(body);
        }
        if self.states[body] == ResponseState::Masses {
            return None;
        }
        let Motion { integrators, workers, .. } = &mut *self.motion;
        let (integrator, system) = (&mut integrators[body], &self.bodies[body].system);
        let pool = workers.pool(system.elements());
        let report = pool.install(|| integrator.respond(pool, system, constraints, impulses, tolerance));
        changes.copy_from_slice(integrator.response());
        Some(report.iterations)
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }
}
