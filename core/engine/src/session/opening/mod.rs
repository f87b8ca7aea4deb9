//! Opening a scene: creates its models, plugins, bodies and tools.

mod body;
mod devices;
mod edit_radii;
mod lattice;
mod models;
mod obstacles;
mod plugins;
mod tool;
mod warnings;

pub(super) use lattice::region_radius;

use super::body_contacts::BodyContacts;
use super::clock::Clock;
use super::editing::Editing;
use super::interactions::Interactions;
use super::level_choice::{LevelChosen, ToolRadii};
use super::motion::Motion;
use super::obstacles::Obstacles;
use super::seam_pairs::Seam;
use super::seams::Seams;
use super::shared::SharedParts;
use super::sleep::Sleep;
use super::step_limits::StepLimits;
use super::step_loads::StepLoads;
use super::timeout::StepGuard;
use super::warning::Warnings;
use super::workers::{Workers, processors};
use super::{Choices, DeviceSlot, Events, Frame, Inputs, Session, SessionError, ToolSlot, mirror, place};
use crate::body::{Body, Model, SymmetryPlane};
use crate::memory::{MemoryAccount, MemoryBudget};
use crate::obstacle::Obstacle;
use crate::plan::Plan;
use crate::scene::{Scene, Source};
use pliant_host::{DeviceInfo, SearchPath};
use pliant_plugin_api::lanes::check_vector_unit;
use pliant_solver::Scheme;
use std::path::PathBuf;
use std::sync::Arc;

/// Options of [`Session::open`].
pub struct Options {
    /// Folders in which plugins are searched for.
    pub search: SearchPath,
    /// Number of threads; 0 for all processors.
    pub threads: usize,
    /// Whether more threads than processors are started if asked for. They take turns and wait for each other, which shows that results do not
    /// depend on the number of threads and is of no other use.
    pub oversubscribe: bool,
    /// Model file that replaces the one of the first body.
    pub mesh: Option<PathBuf>,
    /// Device information by device name: these devices are not opened, because the caller provides the poses of their hands.
    pub recorded: Option<Vec<(String, DeviceInfo)>>,
    /// Largest memory of the session, estimated before it is allocated.
    pub memory: MemoryBudget,
}

impl Options {
    /// Options with these plugin folders and number of threads (0 for all processors); models and devices are those of the scene, and memory is the
    /// default budget.
    pub fn new(search: SearchPath, threads: usize) -> Self {
        Self { search, threads, oversubscribe: false, mesh: None, recorded: None, memory: MemoryBudget::default() }
    }

    /// Numbers of threads that are asked for and that are used, at least 1.
    fn thread_counts(&self) -> (usize, usize) {
        match (self.threads, processors()) {
            (0, processors) => (processors, processors),
            (asked, _) if self.oversubscribe => (asked, asked),
            (asked, processors) => (asked, asked.min(processors)),
        }
    }
}

impl Session {
    /// Opens the parts of a scene that `plan` needs.
    ///
    /// # Errors
    /// Returns an error if a model or plugin cannot be used, or if an explicit integrator exceeds its step limit.
    pub fn open(scene: &Scene, source: &Source, plan: Plan, options: &Options) -> Result<Self, SessionError> {
        Self::open_shared(scene, source, plan, options, &SharedParts::default())
    }

    /// The same, reusing models and grids in `shared`. Results are bit-identical to those of [`Session::open`].
    ///
    /// # Errors
    /// Those of [`Session::open`].
    pub fn open_shared(
        scene: &Scene,
        source: &Source,
        plan: Plan,
        options: &Options,
        shared: &SharedParts,
    ) -> Result<Self, SessionError> {
        check_vector_unit().map_err(SessionError::VectorUnit)?;
        let mut opening = Opening::new(scene, source, &plan, options, shared)?;
        let models = opening.models(scene)?;
        let devices = plan.devices.iter().map(|&d| opening.device(scene, d, &models)).collect::<Result<Vec<_>, _>>()?;
        let (bodies, standing) = opening.bodies(scene, &plan, models)?;
        let mut tools = opening.tools(scene, &plan, &devices, bodies.len())?;
        let unpaired = mirror::join(&mut tools, &plan.mirrors, &bodies);
        let obstacles = opening.obstacles(scene)?;
        let measured_keys = std::mem::take(&mut opening.measured_keys);
        let opened = Opened { bodies, standing, devices, tools, obstacles, unpaired };
        let mut session = opening.session(scene, plan, opened);
        session.open_pads();
        let has_undo = session.inputs.recordings.iter().any(|recording| recording.has_undo());
        session.editing.history.kept = !session.plan.history_steps.is_empty() || has_undo;
        session.sample(shared)?;
        session.check_contact_laws(scene, source)?;
        session.meet(scene);
        session.measure(shared, &measured_keys)?;
        session.choose(scene)?;
        session.open_stitches(scene, source)?;
        session.check_paint_params(scene, source)?;
        session.limit_painting(scene, source);
        session.choices.threads = session.motion.pool().threads();
        session.find_opening_warnings(scene, source, options.mesh.is_some())?;
        Ok(session)
    }
}

/// A scene that is being opened.
pub(super) struct Opening<'a> {
    pub(super) source: &'a Source,
    pub(super) options: &'a Options,
    shared: &'a SharedParts,
    pub(super) dt: f64,
    pub(super) tool_radii: ToolRadii,
    /// Levels chosen where the scene leaves the choice.
    levels: Vec<LevelChosen>,
    /// Levels to which large faces of models were divided.
    subdivisions: Vec<LevelChosen>,
    /// What has been read and loaded.
    pub(super) inputs: Inputs,
    events: Events,
    /// For each moving body, the cache key of its frequencies; empty if it has none.
    measured_keys: Vec<String>,
    /// Seams of each moving body.
    seams: Vec<Vec<Seam>>,
    pub(super) memory: MemoryAccount,
    /// Largest number of contacts that have a local region at a time.
    pub(super) regions: usize,
    /// Whether the integrator may be an implicit one.
    pub(super) is_implicit: bool,
}

/// Parts of a scene that have been opened.
struct Opened {
    bodies: Vec<Body>,
    standing: Vec<(String, Arc<Model>)>,
    devices: Vec<DeviceSlot>,
    tools: Vec<ToolSlot>,
    obstacles: Vec<Obstacle>,
    /// Planes about which vertices are to be paired.
    unpaired: Option<Vec<SymmetryPlane>>,
}

impl<'a> Opening<'a> {
    /// Nothing opened yet; the shapes of the tools are known.
    fn new(
        scene: &Scene,
        source: &'a Source,
        plan: &Plan,
        options: &'a Options,
        shared: &'a SharedParts,
    ) -> Result<Self, SessionError> {
        let mut tool_radii = ToolRadii::default();
        for tool in &plan.tools {
            tool_radii.add(place::shape(&scene.tool[*tool], source)?.shape().length_scale());
        }
        Ok(Self {
            source,
            options,
            shared,
            dt: scene.time.dt.get_ref().si,
            tool_radii,
            levels: Vec::new(),
            subdivisions: Vec::new(),
            inputs: Inputs::default(),
            events: Events::default(),
            measured_keys: Vec::new(),
            seams: Vec::new(),
            memory: MemoryAccount::new(options.memory),
            regions: plan.tools.len(),
            is_implicit: scene.time.integrator.scheme().is_none_or(Scheme::is_implicit),
        })
    }

    /// The session of what has been opened, at time 0, without mirrored tools, integrators and measured frequencies.
    fn session(self, scene: &Scene, plan: Plan, opened: Opened) -> Session {
        let Opened { bodies, standing, devices, tools, obstacles, unpaired } = opened;
        let source = self.source;
        let places = scene.obstacle.iter().map(|obstacle| source.error(obstacle.name.span(), "").place()).collect();
        let count = bodies.len();
        let (asked, threads) = self.options.thread_counts();
        let has_seams = self.seams.iter().any(|seams| !seams.is_empty());
        let sleep = Sleep::new(scene.time.sleep.as_ref().map_or(0.0, |s| s.get_ref().si), count);
        let loads = StepLoads::new(tools.len(), if has_seams { count } else { 0 });
        let motion =
            Motion::new(Workers::new(asked, threads, count), StepLimits::new(&scene.time), sleep, loads, count);
        let obstacles = Obstacles::new(obstacles, places, count);
        let seams = Seams::new(if has_seams { self.seams } else { Vec::new() });
        Session {
            interactions: Interactions::new(obstacles, BodyContacts::new(&plan, &bodies), seams, count),
            bodies,
            standing,
            devices,
            tools,
            choices: Choices {
                integrator: "none",
                why: "nothing moves".into(),
                step_limit: None,
                certain_step_limit: None,
                substeps: 1,
                threads,
                contacts: Vec::new(),
                levels: self.levels,
                subdivisions: self.subdivisions,
                preconditioners: Vec::new(),
            },
            inputs: Inputs { memory: self.memory.into_bodies(), ..self.inputs },
            events: self.events,
            warnings: Warnings::new(source.error(0..0, "").place(), plan.edits.len()),
            plan,
            clock: Clock { dt: self.dt, steps: 0 },
            guard: StepGuard::new(scene.time.patience.get_ref().si),
            motion,
            editing: Editing::new(count, unpaired),
            frame: Frame::default(),
        }
    }
}
