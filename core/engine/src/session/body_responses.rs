//! Answers of the bodies of a session to contact impulses, after they have moved ([`Compliance`]).

use super::Session;
use crate::contact::Compliance;
use pliant_solver::{Constraint, Loads, StepTime, Vec3};

/// The bodies of a session after they have moved, each with the matrix of its step.
pub(super) struct BodyResponses<'a> {
    session: &'a mut Session,
    time: StepTime,
    /// What each body answers with (n).
    states: &'a mut Vec<ResponseState>,
    /// Bodies whose matrix could not be assembled, and why.
    pub failed: Vec<(usize, String)>,
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
    /// The bodies at the end of the step of `time`.
    pub(super) fn new(session: &'a mut Session, time: StepTime, states: &'a mut Vec<ResponseState>) -> Self {
        states.clear();
        states.resize(session.bodies.len(), ResponseState::Untouched);
        Self { session, time, states, failed: Vec::new() }
    }

    /// Adds the forces of constraints under the impulses to the reactions, and lets the solvers go on from their steps.
    pub(super) fn end(self) -> Vec<(usize, String)> {
        for (integrator, state) in self.session.integrators.iter_mut().zip(&*self.states) {
            if *state == ResponseState::Matrix {
                integrator.end_responses();
            }
        }
        self.failed
    }

    /// Prepares the matrix of a body.
    fn begin(&mut self, index: usize) -> ResponseState {
        if !self.session.limits.scheme.is_implicit() || self.session.bodies[index].frozen.is_some() {
            return ResponseState::Masses;
        }
        self.session.swap_springs(index);
        let Session { integrators, bodies, workers, scratch, .. } = &mut *self.session;
        let system = &mut bodies[index].system;
        let loads = Loads { gravity: Vec3::zeros(), forces: &[], tools: &scratch.springs };
        let pool = workers.pool(system.elements());
        let (integrator, time) = (&mut integrators[index], self.time);
        let begun = pool.install(|| integrator.begin_responses(pool, system, &loads, time));
        self.session.swap_springs(index);
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
        let Session { integrators, bodies, workers, .. } = &mut *self.session;
        let (integrator, system) = (&mut integrators[body], &bodies[body].system);
        let pool = workers.pool(system.elements());
        let report = pool.install(|| integrator.respond(pool, system, constraints, impulses, tolerance));
        changes.copy_from_slice(integrator.response());
        Some(report.iterations)
    }

    fn is_cancelled(&self) -> bool {
        self.session.guard.cancel.is_cancelled()
    }
}

impl Session {
    /// Exchanges the springs of tools on a body with those in `scratch`.
    fn swap_springs(&mut self, index: usize) {
        for (slot, springs) in self.tools.iter_mut().zip(&mut self.scratch.springs) {
            std::mem::swap(slot.tool.springs_mut(index), springs);
        }
    }
}
