//! The report of `pliant plan`: what a run of a scene will do, in numbers.

use crate::summary::{BodySummary, summarize_bodies};
use pliant_engine::memory::BodyMemory;
use pliant_engine::plan::LeftOut;
use pliant_engine::session::{Choices, EditCost, Loaded, ObstacleSummary, Session, StepCost, Warning};
use serde::Serialize;
use std::time::Duration;

/// What a run of an opened scene will do.
#[derive(Clone, Debug, Serialize)]
pub struct PlanReport {
    /// Number of steps.
    pub steps: u64,
    /// Step of the simulation, s.
    pub dt: f64,
    /// Integrator, step limits, substeps and threads, and why they were chosen.
    pub choices: Choices,
    /// Plugins that were opened.
    pub loaded: Vec<Loaded>,
    /// Parts that the scene does not need, and why.
    pub left_out: Vec<LeftOut>,
    /// The simulated bodies.
    pub bodies: Vec<BodySummary>,
    /// Obstacles of the scene, with what a distance to each costs.
    pub obstacles: Vec<ObstacleSummary>,
    /// Estimate of the largest memory of a run, bytes.
    pub memory: u64,
    /// Its part for each body of the scene.
    pub memory_of_bodies: Vec<BodyMemory>,
    /// Wall-clock time of opening the scene, s.
    pub open_seconds: f64,
    /// Cost of a step of each body under a tool, measured when the scene was opened.
    pub step_cost: Vec<StepCost>,
    /// Cost of a step of each body under each edit of the scene.
    pub edit_cost: Vec<EditCost>,
    /// Settings without the expected effect, as far as they are known after opening.
    pub warnings: Vec<Warning>,
}

impl PlanReport {
    /// The report of a session that takes `steps` steps and was opened in the time `opening`.
    pub fn new(session: &Session, steps: u64, opening: Duration) -> Self {
        Self {
            steps,
            dt: session.dt(),
            choices: session.choices.clone(),
            loaded: session.inputs.loaded.clone(),
            left_out: session.plan().left_out.clone(),
            bodies: summarize_bodies(session),
            obstacles: session.obstacle_summaries(),
            memory: session.memory_estimate(),
            memory_of_bodies: session.memory_of_bodies().to_vec(),
            open_seconds: opening.as_secs_f64(),
            step_cost: session.step_costs().to_vec(),
            edit_cost: session.edit_costs().to_vec(),
            warnings: session.warnings(),
        }
    }
}
