//! What a run of a scene will do, in numbers: `pliant plan`.

use crate::summary::{BodySummary, summarize_bodies};
use pliant_engine::plan::LeftOut;
use pliant_engine::session::{Choices, Loaded, Session, StepCost, Warning};
use serde::Serialize;
use std::time::Duration;

/// What a run of an opened scene will do.
#[derive(Clone, Debug, Serialize)]
pub struct PlanReport {
    /// Number of steps.
    pub steps: u64,
    /// s, step of the simulation
    pub dt: f64,
    /// Integrator, step limits, substeps and threads, and why they were chosen.
    pub choices: Choices,
    /// Plugins that were opened.
    pub loaded: Vec<Loaded>,
    /// Parts the scene does without, and why.
    pub left_out: Vec<LeftOut>,
    /// The simulated bodies.
    pub bodies: Vec<BodySummary>,
    /// Bytes of the largest data structures, before a tool touches anything.
    pub memory: usize,
    /// s, wall clock, of opening the scene
    pub open_seconds: f64,
    /// Cost of a step of each body under a tool, measured when the scene was opened.
    pub step_cost: Vec<StepCost>,
    /// What will have no effect, or not the one it looks like, as far as opening the scene tells.
    pub warnings: Vec<Warning>,
}

impl PlanReport {
    /// The report of a session that takes `steps` steps and was opened in the time `opening`.
    pub fn new(session: &Session, steps: u64, opening: Duration) -> Self {
        Self {
            steps,
            dt: session.dt(),
            choices: session.choices.clone(),
            loaded: session.loaded.clone(),
            left_out: session.left_out.clone(),
            bodies: summarize_bodies(session),
            memory: session.bytes(),
            open_seconds: opening.as_secs_f64(),
            step_cost: session.step_costs().to_vec(),
            warnings: session.warnings(),
        }
    }
}
