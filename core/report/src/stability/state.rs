//! States of a run, from its energy.

use super::energy::{EnergyBalance, GROWTH};
use crate::scene_run::{RunResult, SceneRun};
use pliant_engine::session::SessionError;

/// Behaviour of the energy of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RunState {
    /// The motion continues within the energy supplied.
    Stable,
    /// The motion decays by half between the second and the last quarter.
    Damped,
    /// The energy exceeds the supplied energy by half, or the state is not finite.
    Growing,
    /// The scene was refused and not run.
    Refused,
    /// A solve did not meet its tolerance; the energy is bounded.
    NotConverged,
}

impl RunState {
    /// Name in rows and catalogues.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Damped => "damped",
            Self::Growing => "growing",
            Self::Refused => "refused",
            Self::NotConverged => "not converged",
        }
    }
}

/// A run with its state.
pub(super) struct ClassifiedRun {
    pub(super) state: RunState,
    pub(super) balance: EnergyBalance,
    pub(super) result: Result<RunResult, SessionError>,
}

/// Steps before a run may be stopped because it grows: the energy of explicit Euler is a step ahead of the work.
const FIRST_STEPS: usize = 20;
/// Excess of energy at which a growing run is stopped.
const STOP_EXCESS: f64 = 1e3;

/// Runs a scene and finds its state. A run that grows is stopped.
pub(super) fn run_and_classify(run: &SceneRun<'_>) -> ClassifiedRun {
    let mut balance = EnergyBalance::default();
    let result = run.run(&[], |session| {
        balance.step(session);
        balance.kinetic.len() < FIRST_STEPS || balance.excess() < STOP_EXCESS
    });
    let state = match &result {
        Err(_) => RunState::Refused,
        Ok(result) if result.frozen.is_some() => RunState::Growing,
        Ok(_) if balance.excess() > GROWTH => RunState::Growing,
        Ok(result) if result.unconverged > 0 => RunState::NotConverged,
        Ok(_) if balance.is_damped() => RunState::Damped,
        Ok(_) => RunState::Stable,
    };
    ClassifiedRun { state, balance, result }
}
