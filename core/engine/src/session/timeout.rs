//! Bodies frozen because their plugins took too long. This is the only effect of the wall clock on a session, so recordings store it.

use super::Session;
use crate::body::Body;
use pliant_solver::CancelToken;
use std::time::{Duration, Instant};

/// Stage of a step that took too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Moving its region.
    Region,
    /// Moving its nodes: after the step was done.
    Step,
    /// Moving its nodes: the step was ended, and the body stands where it was before.
    Interrupted,
}

/// A body that was frozen for taking too long.
#[derive(Clone, Debug, PartialEq)]
pub struct StepTimeout {
    /// Number of steps before that one.
    pub step: u64,
    /// Index of the body among the moving bodies.
    pub body: u32,
    /// The stage that took too long.
    pub stage: Stage,
    /// Description for people.
    pub why: String,
}

/// Bodies that were frozen, and those of a recording to be repeated instead of consulting the clock.
#[derive(Debug, Default)]
struct StepTimeouts {
    happened: Vec<StepTimeout>,
    given: Option<Vec<StepTimeout>>,
}

/// What may end a step before its time.
pub(super) struct StepGuard {
    /// Largest wall-clock time of a body's step, s.
    patience: f64,
    /// Cancels the step under way.
    pub(super) cancel: CancelToken,
    /// Whether the last step was cancelled.
    pub(super) is_cancelled: bool,
    /// The body whose step was cancelled: the step goes on with it, after the bodies before it have moved and tools have followed their hands.
    pub(super) resumes_at: Option<usize>,
    timeouts: StepTimeouts,
}

impl StepGuard {
    /// A guard with this `patience` (s).
    pub(super) fn new(patience: f64) -> Self {
        Self {
            patience,
            cancel: CancelToken::default(),
            is_cancelled: false,
            resumes_at: None,
            timeouts: StepTimeouts::default(),
        }
    }

    /// Deadline of the step number `step` of a body that begins at `start`. Where timeouts are given the clock decides nothing: then it is `start` itself, or
    /// `None`.
    pub(super) fn deadline(&self, step: u64, body: usize, start: Instant) -> Option<Instant> {
        match &self.timeouts.given {
            None => start.checked_add(Duration::try_from_secs_f64(self.patience).ok()?),
            Some(_) => self.given(step, body, Stage::Interrupted).map(|_| start),
        }
    }

    /// The given timeout of a stage of the step number `step` of a body.
    fn given(&self, step: u64, body: usize, stage: Stage) -> Option<&StepTimeout> {
        let is_now =
            |timeout: &&StepTimeout| (timeout.step, timeout.body as usize, timeout.stage) == (step, body, stage);
        self.timeouts.given.iter().flatten().find(is_now)
    }

    /// Records whether a stage of the step number `step` of a body, which began at `start`, took too long. Returns the reason then.
    fn judge(&mut self, step: u64, index: usize, body: &Body, stage: Stage, start: Instant) -> Option<String> {
        let (took, allowed) = (start.elapsed().as_secs_f64(), self.patience);
        let why = match &self.timeouts.given {
            None if took <= allowed => return None,
            None => {
                let material = body.system.material.name();
                let discretization = body.discretization.lattice().map_or("its mesh", |lattice| lattice.source.name());
                format!(
                    "`{material}` on `{discretization}` took {took:.3} s over a step; allowed is {allowed} s (`patience`)"
                )
            }
            Some(_) => self.given(step, index, stage)?.why.clone(),
        };
        self.timeouts.happened.push(StepTimeout { step, body: index as u32, stage, why: why.clone() });
        Some(why)
    }
}

impl Session {
    /// Bodies that were frozen for taking too long.
    pub fn timeouts(&self) -> &[StepTimeout] {
        &self.guard.timeouts.happened
    }

    /// Freezes bodies according to a recorded list instead of the clock.
    pub fn repeat_timeouts(&mut self, timeouts: Vec<StepTimeout>) {
        self.guard.timeouts.given = Some(timeouts);
    }

    /// Freezes a body if the stage that began at `start` took too long.
    pub(super) fn check_patience(&mut self, index: usize, stage: Stage, time: f64, start: Instant) {
        let body = &self.bodies[index];
        if body.frozen.is_none()
            && let Some(why) = self.guard.judge(self.clock.steps, index, body, stage, start)
        {
            self.freeze(index, time, why);
        }
    }
}
