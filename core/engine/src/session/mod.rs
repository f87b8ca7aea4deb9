//! A scene, opened: live objects and nothing optional inside.

mod choose;
mod contact_models;
mod devices;
mod edits;
mod error;
mod event;
mod frame;
mod hand_events;
mod history;
mod lapse;
mod mirror;
mod open;
mod opening_warnings;
mod place;
mod ray_miss;
mod shared;
mod sheets;
mod sleep;
mod step;
mod tactile;
mod thread_choice;
mod warning;

pub use devices::HandPose;
pub use error::SessionError;
pub use event::{Event, EventKind, Events};
pub use frame::{Frame, ToolFrame};
pub use history::{Snapshot, SnapshotError};
pub use lapse::{Lapse, Stage};
pub use mirror::Mirror;
pub use open::Options;
pub use shared::{PooledGrid, SharedParts};
pub use warning::{Warning, WarningCode};

use crate::body::{Body, Model};
use crate::contact::{SheetTips, SoftTip};
use crate::plan::{Edit, LeftOut, Plan};
use crate::tool::{ForceSafety, Frame as DeviceFrame, Hand, TactilePad, TipMass, Tool};
use hand_events::Ongoing;
use nalgebra::UnitQuaternion;
use pliant_host::{Device, DeviceInfo, Pose};
use pliant_mesh::geometry::Vec3;
use pliant_plugin_api::abi::Ball;
use pliant_solver::{Frequencies, Integrator, NodeSprings, Pool, Scheme};
use serde::Serialize;
use std::sync::Arc;
use thread_choice::ThreadChoice;

/// An opened device.
pub struct DeviceSlot {
    /// As the scene calls it.
    pub name: String,
    /// `None` once it is lost, and where somebody else has it.
    pub device: Option<Device>,
    /// What it said of itself.
    pub facts: DeviceInfo,
    /// Its axes in the scene.
    pub frame: DeviceFrame,
    /// Where samples come from, for messages: name, plugin and texts it was given, such as an address.
    pub origin: String,
    poses: Vec<Pose>,
    /// Whether the caller puts its hands somewhere, see [`Session::place_hand`].
    driven: bool,
    /// What it had counted when it was lost.
    counted: Vec<(String, u64)>,
}

impl DeviceSlot {
    /// What it has counted since it was opened, also where it was lost since; nothing while somebody else has it.
    pub fn counters(&self) -> Vec<(String, u64)> {
        self.device.as_ref().map_or_else(|| self.counted.clone(), Device::counters)
    }

    fn lose(&mut self) {
        self.counted = self.counters();
        self.device = None;
    }

    /// The hands of the last step.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }
}

/// A tool and what is between it and its device.
pub struct ToolSlot {
    /// State of the tool.
    pub tool: Tool,
    /// The hand that holds it.
    pub hand: Hand,
    /// What the force passes last.
    pub safety: ForceSafety,
    /// What its tactile array shows, if its device has one.
    pub pad: Option<TactilePad>,
    /// m, where on a body it was in contact, in the rest shape.
    slid_from: Option<(u32, Vec3)>,
    /// Place of its device, and which of its effectors.
    pub device: usize,
    /// Index of the effector of that device.
    pub effector: usize,
    /// Whose hand it mirrors, if it is a mirrored tool.
    pub mirror: Option<Mirror>,
    edit: Option<usize>,
    /// For each body, how it meets it if not by holding vertices.
    soft: Vec<Option<SoftTip>>,
    restitution: f64,
    /// Events of its hand that are under way.
    ongoing: Ongoing,
    /// The edit that was under way when something was taken back: it does not go on.
    taken_back: Option<usize>,
    /// Of a blade, in the edit under way.
    advances: usize,
    /// m, where the tool was, if it was there
    was: Option<Vec3>,
    /// How its shape was turned then.
    turned: Option<UnitQuaternion<f64>>,
    /// Its tip on sheets, where that has a mass.
    tip: Option<TipMass>,
    /// m, where the hand was, if a tip hung on it
    hand_was: Option<Vec3>,
    /// N, what sheets did to the tip in the last step
    on_sheets: Vec3,
    /// m/s, how what holds the hand moves
    drift: Vec3,
}

/// What blades have done.
#[derive(Clone, Debug, Default)]
pub struct CutCounts {
    /// Advances that changed a mesh.
    pub advances: usize,
    /// m^2, of new cut surface inside of closed bodies, one wall of two
    pub area: f64,
    /// m, of new edge, one side of two
    pub length: f64,
    /// s, of each step in which a blade advanced: mesh, model, lattice and samples
    pub seconds: Vec<f64>,
}

/// What was chosen when the session was opened.
#[derive(Clone, Debug, Serialize)]
pub struct Choices {
    /// How bodies are moved.
    pub integrator: &'static str,
    /// Why, where the scene left it open.
    pub why: String,
    /// s, the largest stable step; absent where there is no limit
    pub step_limit: Option<f64>,
    /// s, the same by Gershgorin's certain bound
    pub certain_step_limit: Option<f64>,
    /// Substeps in a step.
    pub substeps: usize,
    /// Threads that work.
    pub threads: usize,
    /// How tools meet sheets.
    pub contacts: Vec<ContactChoice>,
    /// Of each body, if the integrator solves.
    pub preconditioners: Vec<PreconditionerChosen>,
}

/// How a tool meets a sheet.
#[derive(Clone, Debug, Serialize)]
pub struct ContactChoice {
    /// Name of the tool.
    pub tool: String,
    /// Name of the body, a sheet.
    pub body: String,
    /// As scenes write it.
    pub by: &'static str,
    /// Why, where the scene left it open.
    pub why: String,
}

/// What stands for the inverse of a body's matrix.
#[derive(Clone, Debug, Serialize)]
pub struct PreconditionerChosen {
    /// As the scene calls it.
    pub body: String,
    /// Name of the preconditioner.
    pub preconditioner: &'static str,
    /// Reason for the choice.
    pub why: String,
}

/// What a step of a body costs under a tool, measured when the session was opened.
#[derive(Clone, Debug, Serialize)]
pub struct StepCost {
    /// As the scene calls it.
    pub body: String,
    /// Active around one contact, or in the whole of it.
    pub nodes: usize,
    /// Number of active elements.
    pub elements: usize,
    /// s, all substeps; of an implicit scheme its assembly and forces, without the solver's iterations
    pub seconds: f64,
}

/// A file that was opened for a plugin.
#[derive(Clone, Debug, Serialize)]
pub struct Loaded {
    /// grid, material or device
    pub kind: &'static str,
    /// Id of the plugin.
    pub id: String,
    /// Version of the plugin.
    pub version: String,
    /// Library it was loaded from.
    pub path: String,
}

/// Live objects of a scene.
pub struct Session {
    /// Bodies that move.
    pub bodies: Vec<Body>,
    /// Models on which nothing acts.
    pub standing: Vec<(String, Arc<Model>)>,
    /// Devices in use.
    pub devices: Vec<DeviceSlot>,
    /// Tools in use.
    pub tools: Vec<ToolSlot>,
    /// What was chosen.
    pub choices: Choices,
    /// Files that were opened.
    pub loaded: Vec<Loaded>,
    /// What is not there, and why.
    pub left_out: Vec<LeftOut>,
    /// Events of the session so far.
    pub events: Events,
    plan: Plan,
    pool: Pool,
    /// Of small bodies, and where threads are a hindrance: one.
    alone: Pool,
    thread_choices: Vec<ThreadChoice>,
    integrators: Vec<Integrator>,
    /// Of each body by itself, and with a tool on it.
    frequencies: Vec<Frequencies>,
    planned: Vec<Frequencies>,
    costs: Vec<StepCost>,
    scheme: Scheme,
    most_substeps: usize,
    forced: bool,
    /// s, wall clock, that a step of a body may take
    patience: f64,
    /// s
    dt: f64,
    steps: u64,
    energy: bool,
    /// m/s, below which a body falls asleep; 0 for never
    sleep: f64,
    rests: Vec<sleep::Rest>,
    moved: Vec<f64>,
    /// Tips on each body that is a sheet.
    sheet_tips: Vec<SheetTips>,
    /// What the tools do to the body that is being moved.
    springs: Vec<NodeSprings>,
    balls: Vec<Ball>,
    frame: Frame,
    history: history::History,
    lapses: lapse::Lapses,
    clock: history::HistoryClock,
    cuts: CutCounts,
    opening_warnings: Vec<Warning>,
    /// What each edit of the plan has come to.
    tallies: Vec<warning::EditTally>,
    meetings: warning::Meetings,
    /// Times something was cut after another cut had been taken back, which then cannot be made again.
    cut_branches: u64,
}

impl Session {
    /// s, since the start
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.dt
    }

    /// s
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Number of steps taken since the start.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The end of the last step.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// What was planned.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The threads it works with.
    pub fn pool(&self) -> &Pool {
        &self.pool
    }

    /// The body at a place in the scene, if it moves.
    pub fn body_of_scene(&self, index: usize) -> Option<&Body> {
        let before = self.plan.moving.get(..index)?.iter().filter(|m| **m).count();
        self.plan.moving.get(index).filter(|m| **m).and_then(|_| self.bodies.get(before))
    }

    /// Brings every surface up to date. A body whose grid fails stands still.
    pub fn update_surface(&mut self) {
        let time = self.time();
        for index in 0..self.bodies.len() {
            if let Err(error) = self.bodies[index].update_skin(&self.pool)
                && self.bodies[index].frozen.is_none()
            {
                self.freeze(index, time, error.to_string());
            }
        }
    }

    /// What a step of each body costs under a tool.
    pub fn step_costs(&self) -> &[StepCost] {
        &self.costs
    }

    /// The edit that is under way with a tool. One that was taken back is not, until its button or its span begins anew.
    fn edit_of(&mut self, tool: usize) -> Option<usize> {
        let time = self.time();
        let slot = &mut self.tools[tool];
        let runs = |e: &Edit| {
            let pressed = e.button.is_none_or(|b| slot.hand.buttons >> b & 1 == 1);
            e.tool == tool && e.span.0 <= time && time < e.span.1 && pressed
        };
        let mut running = self.plan.edits.iter().enumerate().filter(|(_, e)| runs(e)).map(|(at, _)| at);
        slot.taken_back = slot.taken_back.filter(|edit| running.clone().any(|other| other == *edit));
        running.find(|edit| slot.taken_back != Some(*edit))
    }

    /// N, what fixings and, on sheets, tools did to each node of a body in the last step (n x 3); zero where nothing did.
    pub fn reactions(&self, body: usize) -> &[Vec3] {
        self.integrators.get(body).map_or(&[], |integrator| &integrator.reaction)
    }

    /// Bytes of the largest parts.
    pub fn bytes(&self) -> usize {
        let solvers = self.integrators.iter().map(Integrator::bytes).sum::<usize>();
        solvers + self.bodies.iter().map(Body::bytes).sum::<usize>()
    }
}
