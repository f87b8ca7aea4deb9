//! Bodies frozen because their plugins took too long. This is the only effect of the wall clock on a session, so recordings store it.

use super::Session;
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
pub struct Lapse {
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
struct Lapses {
    happened: Vec<Lapse>,
    given: Option<Vec<Lapse>>,
}

/// What may end a step before its time.
pub(super) struct Watch {
    /// Largest wall-clock time of a body's step, s.
    pub(super) patience: f64,
    /// Cancels the step under way.
    pub(super) cancel: CancelToken,
    /// Whether the last step was cancelled.
    pub(super) is_cancelled: bool,
    /// The body whose step was cancelled: the step goes on with it, after the bodies before it have moved and tools have followed their hands.
    pub(super) resumes_at: Option<usize>,
    lapses: Lapses,
}

impl Watch {
    /// A watch with this `patience` (s).
    pub(super) fn new(patience: f64) -> Self {
        Self {
            patience,
            cancel: CancelToken::default(),
            is_cancelled: false,
            resumes_at: None,
            lapses: Lapses::default(),
        }
    }
}

impl Session {
    /// Bodies that were frozen for taking too long.
    pub fn lapses(&self) -> &[Lapse] {
        &self.watch.lapses.happened
    }

    /// Freezes bodies according to a recorded list instead of the clock.
    pub fn repeat_lapses(&mut self, lapses: Vec<Lapse>) {
        self.watch.lapses.given = Some(lapses);
    }

    /// Deadline of a body's step that begins at `start`. Where lapses are given the clock decides nothing: then it is `start` itself, or `None`.
    pub(super) fn deadline(&self, index: usize, start: Instant) -> Option<Instant> {
        match &self.watch.lapses.given {
            None => start.checked_add(Duration::try_from_secs_f64(self.watch.patience).ok()?),
            Some(given) => given.iter().any(|lapse| self.is_now(lapse, index, Stage::Interrupted)).then_some(start),
        }
    }

    /// Whether a given lapse is due.
    fn is_now(&self, lapse: &Lapse, index: usize, stage: Stage) -> bool {
        (lapse.step, lapse.body as usize, lapse.stage) == (self.clock.steps, index, stage)
    }

    /// Freezes a body if the stage that began at `start` took too long.
    pub(super) fn check_patience(&mut self, index: usize, stage: Stage, time: f64, start: Instant) {
        let body = &self.bodies[index];
        if body.frozen.is_some() {
            return;
        }
        let took = start.elapsed().as_secs_f64();
        let why = match &self.watch.lapses.given {
            None if took <= self.watch.patience => return,
            None => {
                let material = body.system.material.name();
                let discretization = body.discretization.lattice().map_or("its mesh", |lattice| lattice.source.name());
                let allowed = self.watch.patience;
                format!(
                    "`{material}` on `{discretization}` took {took:.3} s over a step; allowed is {allowed} s (`patience`)"
                )
            }
            Some(given) => {
                let Some(lapse) = given.iter().find(|lapse| self.is_now(lapse, index, stage)) else { return };
                lapse.why.clone()
            }
        };
        self.watch.lapses.happened.push(Lapse { step: self.clock.steps, body: index as u32, stage, why: why.clone() });
        self.freeze(index, time, why);
    }
}
