//! Bodies frozen because their plugins took too long. This is the only effect of the wall clock on a session, so recordings store it.

use super::Session;
use std::time::Instant;

/// Stage of a step that took too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Moving its region.
    Region,
    /// Moving its nodes.
    Step,
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
pub(super) struct Lapses {
    pub(super) happened: Vec<Lapse>,
    pub(super) given: Option<Vec<Lapse>>,
}

impl Session {
    /// Bodies that were frozen for taking too long.
    pub fn lapses(&self) -> &[Lapse] {
        &self.lapses.happened
    }

    /// Freezes bodies according to a recorded list instead of the clock.
    pub fn repeat_lapses(&mut self, lapses: Vec<Lapse>) {
        self.lapses.given = Some(lapses);
    }

    /// Freezes a body if the stage that began at `start` took too long.
    pub(super) fn check_patience(&mut self, index: usize, stage: Stage, time: f64, start: Instant) {
        let body = &self.bodies[index];
        if body.frozen.is_some() {
            return;
        }
        let took = start.elapsed().as_secs_f64();
        let why = match &self.lapses.given {
            None if took <= self.patience => return,
            None => {
                let material = body.system.material.name();
                let discretization =
                    body.discretization.lattice().map_or("its mesh", |lattice| lattice.grid.info().id.as_str());
                let allowed = self.patience;
                format!(
                    "`{material}` on `{discretization}` took {took:.3} s over a step; allowed is {allowed} s (`patience`)"
                )
            }
            Some(given) => {
                let now = |l: &&Lapse| (l.step, l.body as usize, l.stage) == (self.steps, index, stage);
                let Some(lapse) = given.iter().find(now) else { return };
                lapse.why.clone()
            }
        };
        self.lapses.happened.push(Lapse { step: self.steps, body: index as u32, stage, why: why.clone() });
        self.freeze(index, time, why);
    }
}
