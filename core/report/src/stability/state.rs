//! What became of a run, from its energy.
//!
//! The work that gravity, hands and led nodes have done is the most energy a body can hold. A run that holds half as much again
//! has made some: it grows. One whose motion dies away by half between the second and the last quarter is damped.

use super::Trial;
use crate::Outcome;
use pliant_engine::session::{Session, SessionError};
use pliant_solver::{V3, axpy, dot};

/// What became of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Moves on.
    Stable,
    /// Comes to rest.
    Damped,
    /// Holds more energy than was put in, or is no longer finite.
    Growing,
    /// Was not run.
    Refused,
    /// A solve did not meet its tolerance; the run is bounded.
    NotConverged,
}

impl State {
    /// In rows.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Damped => "damped",
            Self::Growing => "growing",
            Self::Refused => "refused",
            Self::NotConverged => "not converged",
        }
    }
}

/// Share of energy over the work done that is growth.
const GROWTH: f64 = 0.5;

/// Energy in and out, J, after every step.
#[derive(Clone, Debug, Default)]
pub(super) struct Ledger {
    /// Nodes of each body before the step.
    before: Vec<Vec<V3>>,
    proxies: Vec<V3>,
    /// Done by gravity, by what holds and leads nodes, and by tools.
    pub(super) work: f64,
    /// Of it, what friction between tips and sheets took.
    pub(super) rubbed: f64,
    /// The largest sum of what was done and taken, whatever its sign.
    pub(super) scale: f64,
    /// Kinetic and elastic, at the end of each step.
    pub(super) kinetic: Vec<f64>,
    pub(super) elastic: Vec<f64>,
    /// What was held beyond the work done, at most.
    pub(super) injected: f64,
    /// What rounding alone may come to: a speed of 1 nm/s.
    floor: f64,
}

/// (m/s)^2
const SLOW: f64 = 1e-18;
/// Steps before a run may be stopped because it grows: the energy of explicit Euler is a step ahead of the work.
const FIRST: usize = 20;

impl Ledger {
    pub(super) fn step(&mut self, session: &Session) {
        let gravity = session.plan().gravity;
        for (index, body) in session.bodies.iter().enumerate() {
            let nodes = &body.system.nodes;
            if self.before.len() <= index {
                self.before.push(nodes.rest.clone());
            }
            let before = &mut self.before[index];
            self.floor = self.floor.max(SLOW * nodes.mass.iter().sum::<f64>());
            // A region that has moved has other nodes: what they did is not known.
            if before.len() == nodes.len() {
                let g = if body.carrier.is_whole() { gravity } else { [0.0; 3] };
                for (i, held) in session.reactions(index).iter().enumerate() {
                    let u = axpy(nodes.x[i], -1.0, before[i]);
                    let done = dot(axpy(*held, nodes.mass[i], g), u);
                    (self.work, self.scale) = (self.work + done, self.scale + done.abs());
                }
            }
            before.clone_from(&nodes.x);
        }
        let on_lattice = session.bodies.iter().any(|b| b.carrier.sheet().is_none());
        let frame = session.frame();
        for (i, tool) in frame.tools.iter().enumerate().filter(|_| on_lattice) {
            if let Some(before) = self.proxies.get(i) {
                // The hand feels the opposite of what the body does.
                let done = -dot(tool.force, axpy(tool.hand, -1.0, *before));
                (self.work, self.scale) = (self.work + done, self.scale + done.abs());
            }
        }
        self.proxies = frame.tools.iter().map(|t| t.hand).collect();
        // What is done to the sheet is what the hand does, less friction.
        (self.work, self.rubbed) = (self.work + frame.rubbed, self.rubbed + frame.rubbed);
        let held = frame.kinetic_energy + frame.elastic_energy;
        self.injected =
            if held.is_finite() { self.injected.max(held + self.rubbed - self.work) } else { f64::INFINITY };
        self.kinetic.push(frame.kinetic_energy);
        self.elastic.push(frame.elastic_energy);
    }

    /// Share of energy that came from nothing.
    pub(super) fn excess(&self) -> f64 {
        (self.injected / self.scale.max(self.floor).max(f64::MIN_POSITIVE)).max(0.0)
    }

    fn state(&self) -> State {
        if self.excess() > GROWTH {
            return State::Growing;
        }
        let quarter = self.kinetic.len() / 4;
        let most = |range: std::ops::Range<usize>| self.kinetic[range].iter().copied().fold(0.0, f64::max);
        if quarter == 0 {
            return State::Stable;
        }
        let (early, late) = (most(quarter..2 * quarter), most(3 * quarter..self.kinetic.len()));
        if late < 0.5 * early { State::Damped } else { State::Stable }
    }
}

/// Runs and judges. A run that grows is stopped.
pub(super) fn judge(trial: &Trial<'_>) -> (State, Ledger, Result<Outcome, SessionError>) {
    let mut ledger = Ledger::default();
    let outcome = trial.run(&[], |session| {
        ledger.step(session);
        ledger.kinetic.len() < FIRST || ledger.excess() < 1e3
    });
    let state = match &outcome {
        Err(_) => State::Refused,
        Ok(outcome) if outcome.frozen.is_some() => State::Growing,
        Ok(outcome) => match ledger.state() {
            State::Growing => State::Growing,
            _ if outcome.unconverged > 0 => State::NotConverged,
            other => other,
        },
    };
    (state, ledger, outcome)
}
