//! A session: an opened scene with its bodies, devices and tools.

mod body_contacts;
mod body_responses;
mod choices;
mod choose;
mod clock;
mod command;
mod contact_law_checks;
mod contact_models;
mod device_slot;
mod devices;
mod division;
mod edit_costs;
mod editing;
mod edits;
mod error;
mod event;
mod fibres;
mod fields;
mod fixings;
mod frame;
mod hand_events;
mod history;
mod inputs;
mod interactions;
mod level_choice;
mod memory_checks;
mod mirror;
mod motion;
mod obstacles;
mod opening;
mod overlap;
mod place;
mod proxy_places;
mod ray_miss;
mod recorded;
mod sculpt_layers;
mod seam_pairs;
mod seams;
mod shared;
mod sheets;
mod sleep;
mod step;
mod step_limits;
mod step_loads;
mod stiffness;
mod stitch_strokes;
mod subdivision;
mod surface_values;
mod tactile;
mod thread_choice;
mod tied_bodies;
mod ties;
mod timeout;
mod tool_slot;
mod warning;
mod workers;

pub use choices::{Choices, ContactChoice, PreconditionerChosen};
pub use command::SessionCommand;
pub use contact_models::LIVE_TIP_MASS;
pub use device_slot::DeviceSlot;
pub use devices::HandPose;
pub use division::SplitError;
pub use edit_costs::EditCost;
pub use error::SessionError;
pub use event::{Event, EventKind, Events};
pub use frame::{Frame, ToolFrame};
pub use history::{CutCounts, HistoryCounts, Snapshot, SnapshotError};
pub use inputs::{Inputs, Loaded};
pub use level_choice::LevelChosen;
pub use mirror::Mirror;
pub use obstacles::ObstacleSummary;
pub use opening::Options;
pub use proxy_places::TouchingProxy;
pub use sculpt_layers::SculptLayerState;
pub use shared::SharedParts;
pub use step_limits::StepCost;
pub use stiffness::StiffnessState;
pub use timeout::{Stage, StepTimeout};
pub use tool_slot::ToolSlot;
pub use warning::{Warning, WarningCode};
pub use workers::processors;

use crate::body::{Body, Model};
use crate::memory::BodyMemory;
use crate::plan::{Edit, Plan};
use clock::Clock;
use editing::Editing;
use interactions::Interactions;
use motion::Motion;
use pliant_mesh::geometry::Vec3;
use pliant_solver::Pool;
pub use pliant_solver::{CancelToken, MAX_THREADS};
use std::sync::Arc;
use timeout::StepGuard;
use warning::Warnings;

/// An opened scene.
pub struct Session {
    /// Bodies that move.
    pub bodies: Vec<Body>,
    /// Models of bodies that do not move.
    pub standing: Vec<(String, Arc<Model>)>,
    /// Devices in use.
    pub devices: Vec<DeviceSlot>,
    /// Tools in use.
    pub tools: Vec<ToolSlot>,
    /// Choices made when it was opened.
    pub choices: Choices,
    /// What was read and loaded when it was opened.
    pub inputs: Inputs,
    /// Events of the session so far.
    pub events: Events,
    plan: Plan,
    clock: Clock,
    guard: StepGuard,
    motion: Motion,
    interactions: Interactions,
    editing: Editing,
    warnings: Warnings,
    frame: Frame,
}

impl Session {
    /// Simulated time since the start, s.
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// Size of a step of simulated time, s.
    pub fn dt(&self) -> f64 {
        self.clock.dt
    }

    /// Number of steps taken since the start.
    pub fn steps(&self) -> u64 {
        self.clock.steps
    }

    /// Results at the end of the last step.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The plan it was opened with.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Its worker pool.
    pub fn pool(&self) -> &Pool {
        self.motion.pool()
    }

    /// The moving body with this index in the scene; `None` if that body does not move.
    pub fn body_of_scene(&self, index: usize) -> Option<&Body> {
        let before = self.plan.moving.get(..index)?.iter().filter(|m| **m).count();
        self.plan.moving.get(index).filter(|m| **m).and_then(|_| self.bodies.get(before))
    }

    /// Updates the surface of every body. A body whose grid fails is frozen.
    pub fn update_surface(&mut self) {
        let time = self.time();
        for index in 0..self.bodies.len() {
            let body = &mut self.bodies[index];
            let updated = body.update_skin(self.motion.pool());
            let updated = updated.and_then(|()| self.interactions.obstacles.clear_skin(index, body));
            if let Err(error) = updated
                && self.bodies[index].frozen.is_none()
            {
                self.freeze(index, time, error.to_string());
            }
        }
    }

    /// Cost of a step of each body with a tool.
    pub fn step_costs(&self) -> &[StepCost] {
        &self.motion.limits.costs
    }

    /// The edit of the plan that is active for a tool. An edit that was undone is inactive until its button is pressed or its time span begins again.
    fn edit_of(&mut self, tool: usize) -> Option<usize> {
        let time = self.time();
        let slot = &mut self.tools[tool];
        let runs = |e: &Edit| {
            let pressed = e.button.is_none_or(|b| slot.hand.buttons >> b & 1 == 1);
            e.tool == tool && e.span.contains(time) && pressed
        };
        let mut running = self.plan.edits.iter().enumerate().filter(|(_, e)| runs(e)).map(|(at, _)| at);
        slot.taken_back = slot.taken_back.filter(|edit| running.clone().any(|other| other == *edit));
        running.find(|edit| slot.taken_back != Some(*edit))
    }

    /// Constraint forces of fixings and, on sheets, of tools on each node of a body in the last step, N (n x 3); zero at free nodes.
    pub fn reactions(&self, body: usize) -> &[Vec3] {
        self.motion.reactions(body)
    }

    /// Estimate of the largest memory of a run, bytes, made before the bodies were allocated.
    pub fn memory_estimate(&self) -> u64 {
        crate::memory::total(&self.inputs.memory)
    }

    /// The part of [`Session::memory_estimate`] of each body of the scene.
    pub fn memory_of_bodies(&self) -> &[BodyMemory] {
        &self.inputs.memory
    }

    /// Memory of the largest parts at present, bytes.
    pub fn bytes(&self) -> usize {
        self.motion.bytes() + self.bodies.iter().map(Body::bytes).sum::<usize>()
    }
}
