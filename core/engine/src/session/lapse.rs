//! Where the wall clock decides: a body whose plugins take too long stands still. What a recording must say, as nothing else
//! in a session depends on time that has passed outside of it.

use super::Session;
use std::time::Instant;

/// What of a step took too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Moving its region.
    Region,
    /// Moving its nodes.
    Step,
}

/// A body that was given up.
#[derive(Clone, Debug, PartialEq)]
pub struct Lapse {
    /// Steps taken before that one.
    pub step: u64,
    /// Place among the bodies that move.
    pub body: u32,
    /// After which stage.
    pub stage: Stage,
    /// Description for people.
    pub why: String,
}

/// Those that have been, and those that are to be instead of what the clock says.
#[derive(Debug, Default)]
pub(super) struct Lapses {
    pub(super) happened: Vec<Lapse>,
    pub(super) given: Option<Vec<Lapse>>,
}

impl Session {
    /// Bodies that were given up for taking too long.
    pub fn lapses(&self) -> &[Lapse] {
        &self.lapses.happened
    }

    /// Gives bodies up as this list says, and no more as the clock says.
    pub fn repeat_lapses(&mut self, lapses: Vec<Lapse>) {
        self.lapses.given = Some(lapses);
    }

    /// Gives up on a body whose plugins took too long over what began at `start`.
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
