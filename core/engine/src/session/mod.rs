//! A session: an opened scene with its bodies, devices and tools.

mod body_contacts;
mod body_responses;
mod choose;
mod command;
mod contact_law_checks;
mod contact_models;
mod devices;
mod division;
mod edit_costs;
mod edits;
mod error;
mod event;
mod fibres;
mod fields;
mod fixings;
mod frame;
mod hand_events;
mod history;
mod level_choice;
mod memory_checks;
mod mirror;
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
mod stiffness;
mod stitch_strokes;
mod subdivision;
mod surface_values;
mod tactile;
mod thread_choice;
mod tied_bodies;
mod ties;
mod timeout;
mod warning;
mod workers;

pub use command::SessionCommand;
pub use contact_models::LIVE_TIP_MASS;
pub use devices::HandPose;
pub use division::SplitError;
pub use edit_costs::EditCost;
pub use error::SessionError;
pub use event::{Event, EventKind, Events};
pub use frame::{Frame, ToolFrame};
pub use history::{HistoryCounts, Snapshot, SnapshotError};
pub use level_choice::LevelChosen;
pub use mirror::Mirror;
pub use obstacles::ObstacleSummary;
pub use opening::Options;
pub use proxy_places::TouchingProxy;
pub use sculpt_layers::SculptLayerState;
use sculpt_layers::SculptLayers;
pub use shared::SharedParts;
pub use stiffness::StiffnessState;
pub use timeout::{Stage, StepTimeout};
pub use warning::{Warning, WarningCode};
pub use workers::processors;

use crate::body::{Body, Model, SymmetryPlane};
use crate::contact::{SheetTips, SoftTip};
use crate::memory::BodyMemory;
use crate::plan::{Edit, LeftOut, Plan};
use crate::recording::RecordedHands;
use crate::tool::{ForceSafety, Frame as DeviceFrame, Hand, TactilePad, TipMass, Tool, TorqueSafety};
use body_contacts::BodyContacts;
use division::DividedBodies;
use hand_events::Ongoing;
use history::History;
use nalgebra::UnitQuaternion;
use obstacles::Obstacles;
use pliant_host::{ContactLaw, Device, DeviceInfo, Pose};
use pliant_mesh::geometry::Vec3;
use pliant_plugin_api::abi::Ball;
pub use pliant_solver::{CancelToken, MAX_THREADS};
use pliant_solver::{Integrator, NodeSprings, Pool};
use seams::Seams;
use serde::Serialize;
use sleep::Sleep;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use step_limits::StepLimits;
use ties::Ties;
use timeout::StepGuard;
use warning::Warnings;
use workers::Workers;

/// An opened device.
pub struct DeviceSlot {
    /// Name in the scene.
    pub name: String,
    /// The device; `None` if it is lost or the caller has it.
    pub device: Option<Device>,
    /// Information reported by the device.
    pub facts: DeviceInfo,
    /// Its coordinate frame in the scene.
    pub frame: DeviceFrame,
    /// Source of its samples, for messages: name, plugin and text parameters, such as an address.
    pub origin: String,
    poses: Vec<Pose>,
    /// The recording that it takes its hands from, and its index among the recorded devices; `None` for a plugin's device.
    recorded: Option<(Arc<RecordedHands>, usize)>,
    /// Whether the caller places its hands, see [`Session::place_hand`].
    driven: bool,
    /// Its counters at the time it was lost.
    counted: Vec<(String, u64)>,
}

impl DeviceSlot {
    /// Its counters since it was opened, also if it has been lost; empty if the caller has the device.
    pub fn counters(&self) -> Vec<(String, u64)> {
        self.device.as_ref().map_or_else(|| self.counted.clone(), Device::counters)
    }

    fn lose(&mut self) {
        self.counted = self.counters();
        self.device = None;
    }

    /// Path of the recording that it takes its hands from; `None` for a plugin's device.
    pub fn recording(&self) -> Option<&Path> {
        self.recorded.as_ref().map(|(hands, _)| hands.path())
    }

    /// Poses of its hands in the last step.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }
}

/// A tool with its hand, device and force safety.
pub struct ToolSlot {
    /// State of the tool.
    pub tool: Tool,
    /// The hand that holds it.
    pub hand: Hand,
    /// Force safety of its effector.
    pub safety: ForceSafety,
    /// Safety of its torque; `None` for a device that does not state a peak torque.
    pub torque_safety: Option<TorqueSafety>,
    /// Its tactile pad, if its device has an array.
    pub pad: Option<TactilePad>,
    /// Last contact point in the rest shape of a body, m.
    slid_from: Option<(u32, Vec3)>,
    /// Index of its device.
    pub device: usize,
    /// Index of the effector of that device.
    pub effector: usize,
    /// The mirror, if it is a mirrored tool.
    pub mirror: Option<Mirror>,
    /// Whether its blade would cut the same as that of its original, and rests.
    cuts_the_same: bool,
    /// Whether the scene has an edit with it that renders torque.
    pub has_torque: bool,
    edit: Option<usize>,
    /// For each body, its soft tip on that sheet; `None` if it uses contact constraints.
    soft: Vec<Option<SoftTip>>,
    /// Its contact law, if the scene gives one.
    law: Option<Arc<ContactLaw>>,
    restitution: f64,
    /// Ongoing events of its hand.
    ongoing: Ongoing,
    /// The edit that was active at an undo; it does not continue.
    taken_back: Option<usize>,
    /// Where the proxy is when the next edit begins; `None`: at the hand.
    begins_at: Option<proxy_places::Begin>,
    /// Number of advances of its blade in the active edit.
    advances: usize,
    /// Whether the active edit has tied points of two bodies, and whether it has been said that it cannot.
    has_tied: bool,
    is_stitch_refused: bool,
    /// Previous position of the tool, m; `None` if it was absent.
    was: Option<Vec3>,
    /// Previous rotation of its shape.
    turned: Option<UnitQuaternion<f64>>,
    /// Its fingertip on sheets, if that has a mass.
    tip: Option<TipMass>,
    /// Previous position of the hand of a tip with mass, m.
    hand_was: Option<Vec3>,
    /// Force of sheets on the tip in the last step, N.
    on_sheets: Vec3,
    /// Velocity of the contact surface, m/s.
    drift: Vec3,
}

/// Statistics of cuts.
#[derive(Clone, Debug, Default)]
pub struct CutCounts {
    /// Number of advances that changed a mesh.
    pub advances: usize,
    /// Cut area of closed bodies, of one of the two walls, m^2.
    pub area: f64,
    /// Cut length, of one of the two sides, m.
    pub length: f64,
    /// Wall-clock time of cutting in each step with an advance, s: mesh, model, lattice and samples.
    pub seconds: Vec<f64>,
}

/// Choices made when the session was opened.
#[derive(Clone, Debug, Serialize)]
pub struct Choices {
    /// Name of the time integration scheme.
    pub integrator: &'static str,
    /// Reason for the choice; empty if the scene gives it.
    pub why: String,
    /// Largest stable step, s; `None` without a limit.
    pub step_limit: Option<f64>,
    /// Largest stable step by Gershgorin's rigorous bound, s; `None` without a limit.
    pub certain_step_limit: Option<f64>,
    /// Number of substeps in a step.
    pub substeps: usize,
    /// Number of threads.
    pub threads: usize,
    /// Contact methods of tools on sheets.
    pub contacts: Vec<ContactChoice>,
    /// Levels of grids that `level = "auto"` chose.
    pub levels: Vec<LevelChosen>,
    /// How often the faces of bodies with `subdivide` were divided.
    pub subdivisions: Vec<LevelChosen>,
    /// Preconditioner of each body; empty for explicit schemes.
    pub preconditioners: Vec<PreconditionerChosen>,
}

/// Contact method of a tool on a sheet.
#[derive(Clone, Debug, Serialize)]
pub struct ContactChoice {
    /// Name of the tool.
    pub tool: String,
    /// Name of the body, a sheet.
    pub body: String,
    /// Name of the method in scene files.
    pub by: &'static str,
    /// Id of the contact law, for a tool that has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    /// Reason for the choice; empty if the scene gives it.
    pub why: String,
}

/// Preconditioner of a body.
#[derive(Clone, Debug, Serialize)]
pub struct PreconditionerChosen {
    /// Name of the body in the scene.
    pub body: String,
    /// Name of the preconditioner.
    pub preconditioner: &'static str,
    /// Reason for the choice.
    pub why: String,
}

/// Cost of a step of a body with a tool, measured when the session was opened.
#[derive(Clone, Debug, Serialize)]
pub struct StepCost {
    /// Name in the scene.
    pub body: String,
    /// Number of active nodes: around one contact, or of the whole body.
    pub nodes: usize,
    /// Number of active elements.
    pub elements: usize,
    /// Time of all substeps, s; for implicit schemes that of forces and assembly, without solver iterations.
    pub seconds: f64,
}

/// A plugin that was loaded.
#[derive(Clone, Debug, Serialize)]
pub struct Loaded {
    /// Kind: grid, material or device.
    pub kind: &'static str,
    /// Id of the plugin.
    pub id: String,
    /// Version of the plugin.
    pub version: String,
    /// Library it was loaded from.
    pub path: String,
}

/// Step and number of steps.
struct Clock {
    /// Length of a step, s.
    dt: f64,
    /// Number of steps taken.
    steps: u64,
}

/// Buffers of a step.
struct Scratch {
    /// Loads of each tool on the body that is being stepped.
    springs: Vec<NodeSprings>,
    /// Whether the last of them is that of the seams of the body.
    has_seams: bool,
    /// Balls of cells that the tools need.
    balls: Vec<Ball>,
    /// Points of a body that tools grip, m.
    grips: Vec<Vec3>,
}

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
    /// Estimate of the memory of each body of the scene.
    memory: Vec<BodyMemory>,
    /// Plugins that were loaded.
    pub loaded: Vec<Loaded>,
    /// Files of fields and fibres that were read.
    pub field_files: Vec<PathBuf>,
    /// Meshes of obstacles that were read.
    pub obstacle_files: Vec<PathBuf>,
    /// Recordings that its devices take their hands from.
    pub recordings: Vec<Arc<RecordedHands>>,
    /// Commands of the recordings before the last step.
    commands: Vec<SessionCommand>,
    /// Parts of the scene that were left out, and why.
    pub left_out: Vec<LeftOut>,
    /// Events of the session so far.
    pub events: Events,
    plan: Plan,
    clock: Clock,
    workers: Workers,
    limits: StepLimits,
    /// Integrator of each body.
    integrators: Vec<Integrator>,
    guard: StepGuard,
    sleep: Sleep,
    /// Largest displacement of a node of each body in the last step, m.
    moved: Vec<f64>,
    /// Tips on each body; used for sheets.
    sheet_tips: Vec<SheetTips>,
    obstacles: Obstacles,
    body_contacts: BodyContacts,
    seams: Seams,
    /// Planes of a symmetry that the next step pairs the vertices of bodies for.
    unpaired: Option<Vec<SymmetryPlane>>,
    ties: Ties,
    scratch: Scratch,
    frame: Frame,
    stiffness: StiffnessState,
    /// Whether energies are summed in each step.
    energy: bool,
    history: History,
    layers: SculptLayers,
    divided: DividedBodies,
    warnings: Warnings,
}

impl Session {
    /// Simulated time since the start, s.
    pub fn time(&self) -> f64 {
        self.clock.steps as f64 * self.clock.dt
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
        &self.workers.all
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
            let updated = body.update_skin(&self.workers.all).and_then(|()| match self.obstacles.contacts.get(index) {
                Some(obstacles) => obstacles.clear_skin(body),
                None => Ok(()),
            });
            if let Err(error) = updated
                && self.bodies[index].frozen.is_none()
            {
                self.freeze(index, time, error.to_string());
            }
        }
    }

    /// Cost of a step of each body with a tool.
    pub fn step_costs(&self) -> &[StepCost] {
        &self.limits.costs
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
        self.integrators.get(body).map_or(&[], |integrator| &integrator.reaction)
    }

    /// Estimate of the largest memory of a run, bytes, made before the bodies were allocated.
    pub fn memory_estimate(&self) -> u64 {
        crate::memory::total(&self.memory)
    }

    /// The part of [`Session::memory_estimate`] of each body of the scene.
    pub fn memory_of_bodies(&self) -> &[BodyMemory] {
        &self.memory
    }

    /// Memory of the largest parts at present, bytes.
    pub fn bytes(&self) -> usize {
        let solvers = self.integrators.iter().map(Integrator::bytes).sum::<usize>();
        solvers + self.bodies.iter().map(Body::bytes).sum::<usize>()
    }
}
