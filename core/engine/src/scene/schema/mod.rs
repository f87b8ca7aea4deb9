//! The types that a scene file is deserialised into. Their doc comments are the reference of the format: `pliant schema` prints them.

mod body;
mod edit;
mod fibre;
mod hand;
mod level;
mod obstacle;
mod seam;
mod stitch;
mod weld;

pub use body::*;
pub use edit::*;
pub use fibre::*;
pub use hand::*;
pub use level::Level;
pub use obstacle::*;
pub use seam::SeamScene;
pub use stitch::StitchScene;
pub use weld::Weld;

use super::units::{
    Acceleration, Angle, Damping, Force, ForceRate, Frequency, Length, Mass, Speed, Stiffness, Time, Toughness,
};
use pliant_solver::Scheme;
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

/// A scene: bodies, devices, tools, edits, and outputs.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Scene {
    /// Version of this format: 1.
    #[schemars(with = "u32")]
    pub format: Spanned<u32>,
    /// Title, one line.
    #[serde(default)]
    pub title: String,
    /// Duration, step and time integration.
    #[serde(default)]
    pub time: TimeScene,
    /// The solver of implicit integrators.
    #[serde(default)]
    pub solver: SolverScene,
    /// Acceleration of gravity; none by default.
    #[serde(default)]
    pub gravity: Option<[Acceleration; 3]>,
    /// Bodies, the objects that deform.
    #[serde(default)]
    pub body: Vec<BodyScene>,
    /// Points of two bodies that are tied together.
    #[serde(default)]
    #[schemars(with = "Vec<StitchScene>")]
    pub stitch: Vec<Spanned<StitchScene>>,
    /// Obstacles, rigid things that bodies meet.
    #[serde(default)]
    pub obstacle: Vec<ObstacleScene>,
    /// Devices, which sample hands and render forces.
    #[serde(default)]
    pub device: Vec<DeviceScene>,
    /// Tools that hands hold.
    #[serde(default)]
    pub tool: Vec<ToolScene>,
    /// Edits, operations with tools.
    #[serde(default)]
    pub edit: Vec<EditScene>,
    /// Quantities that are measured.
    #[serde(default)]
    pub probe: Vec<ProbeScene>,
    /// Files that a run writes.
    #[serde(default)]
    pub output: OutputScene,
}

/// Duration, step and time integration.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct TimeScene {
    /// Simulated time of the whole run.
    #[schemars(with = "Time")]
    pub duration: Spanned<Time>,
    /// Step size: the time between two samples of the hand.
    #[schemars(with = "Time")]
    pub dt: Spanned<Time>,
    /// Time integration scheme; `auto` chooses symplectic Euler if it is stable with a few substeps, else backward Euler.
    pub integrator: IntegratorChoice,
    /// Number of substeps of explicit integrators; 0 takes as many as the step limit needs.
    #[schemars(with = "u32")]
    pub substeps: Spanned<u32>,
    /// Largest number of substeps; a scene that needs more is refused.
    #[schemars(with = "u32")]
    pub most_substeps: Spanned<u32>,
    /// Whether an explicit integrator may exceed its step limit; the growth of the energy is then reported.
    pub force_unstable: bool,
    /// Wall-clock time that a step of a body may take. A body that exceeds it is quarantined and the rest of the scene goes on.
    #[schemars(with = "Time")]
    pub patience: Spanned<Time>,
    /// Speed below which, for 0.1 s, a body is put to sleep until a tool comes near or a fixing moves. Absent, no body sleeps.
    #[schemars(with = "Option<Speed>")]
    pub sleep: Option<Spanned<Speed>>,
}

impl TimeScene {
    /// Number of steps of the run. A remainder below 1e-12 of the duration is rounding and makes no further step.
    pub fn steps(&self) -> u64 {
        let steps = self.duration.get_ref().si / self.dt.get_ref().si;
        (steps * (1.0 - 1e-12)).ceil().max(1.0) as u64
    }
}

impl Default for TimeScene {
    fn default() -> Self {
        Self {
            duration: Spanned::new(0..0, Time::new(1.0)),
            dt: Spanned::new(0..0, Time::new(1e-3)),
            integrator: IntegratorChoice::default(),
            substeps: Spanned::new(0..0, 0),
            most_substeps: Spanned::new(0..0, 64),
            force_unstable: false,
            patience: Spanned::new(0..0, Time::new(10.0)),
            sleep: None,
        }
    }
}

/// A time integration scheme, or its automatic choice.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum IntegratorChoice {
    /// Chosen by material and step size.
    #[default]
    Auto,
    /// Explicit Euler with new positions from old velocities, as printed by Qi, Zhu and Fan (2019).
    ExplicitEuler,
    /// Symplectic Euler: velocities first, then positions from the new velocities.
    SymplecticEuler,
    /// Backward Euler, first order, with one Newton iteration a step unless `newton` asks for more.
    BackwardEuler,
    /// BDF2, second order, with less numerical damping than backward Euler.
    Bdf2,
    /// Implicit midpoint rule, second order, without numerical damping; steps with a tip at a sheet are those of backward Euler.
    ImplicitMidpoint,
    /// One-leg theta method with theta = 0.55, first order with a tenth of backward Euler's numerical damping.
    DampedMidpoint,
    /// Static equilibrium at every step, without inertia.
    QuasiStatic,
}

impl IntegratorChoice {
    /// The scheme that was chosen; `None` for an automatic choice.
    pub fn scheme(self) -> Option<Scheme> {
        match self {
            Self::Auto => None,
            Self::ExplicitEuler => Some(Scheme::ExplicitEuler),
            Self::SymplecticEuler => Some(Scheme::SymplecticEuler),
            Self::BackwardEuler => Some(Scheme::BackwardEuler),
            Self::Bdf2 => Some(Scheme::Bdf2),
            Self::ImplicitMidpoint => Some(Scheme::ImplicitMidpoint),
            Self::DampedMidpoint => Some(Scheme::DampedMidpoint),
            Self::QuasiStatic => Some(Scheme::QuasiStatic),
        }
    }
}

/// A preconditioner of the linear solver, or its automatic choice.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum PreconditionerChoice {
    /// Chosen by size, stiffness and step size.
    #[default]
    Auto,
    /// The inverses of the 3 x 3 diagonal blocks.
    BlockJacobi,
    /// Block Jacobi on all levels of coarsening, added up.
    Multilevel,
}

/// The solver of implicit integrators.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct SolverScene {
    /// Relative residual at which the linear solver stops.
    #[schemars(with = "f64")]
    pub tolerance: Spanned<f64>,
    /// Largest number of iterations of the linear solver.
    #[schemars(with = "u32")]
    pub iterations: Spanned<u32>,
    /// Largest number of Newton iterations of a step: by default 1, which keeps steps short, and 200 for `quasi-static`.
    #[schemars(with = "Option<u32>")]
    pub newton: Option<Spanned<u32>>,
    /// Residual at which Newton's method stops, relative to the first one of the step.
    #[schemars(with = "f64")]
    pub newton_tolerance: Spanned<f64>,
    /// Preconditioner of the linear solver.
    pub preconditioner: PreconditionerChoice,
}

impl Default for SolverScene {
    fn default() -> Self {
        Self {
            tolerance: Spanned::new(0..0, 1e-6),
            iterations: Spanned::new(0..0, 1000),
            newton: None,
            newton_tolerance: Spanned::new(0..0, 1e-6),
            preconditioner: PreconditionerChoice::Auto,
        }
    }
}

/// Files that a run writes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct OutputScene {
    /// Whether to write `trace.csv`, one row for each step.
    pub trace: bool,
    /// Whether the trace has energies; they cost a pass over the elements in each step.
    pub energy: bool,
    /// Whether to write `nodes.csv`, the nodes at the end.
    pub nodes: bool,
    /// Whether to write `forces.svg`, the reactions of held nodes at the end as arrows.
    pub forces: bool,
    /// Rate, in simulated time, at which OBJ files of the surface are written; none by default.
    #[schemars(with = "Option<Frequency>")]
    pub frames: Option<Spanned<Frequency>>,
    /// Whether the parts of a model, as cuts leave them, also go to files of their own.
    #[schemars(with = "PartsScene")]
    pub parts: Spanned<PartsScene>,
}

/// Files to which the parts of a model are written.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum PartsScene {
    /// Only the file of the model, with all parts.
    #[default]
    Together,
    /// The file of the model with all parts, and a file for each part.
    Files,
}

impl Default for OutputScene {
    fn default() -> Self {
        Self {
            trace: true,
            energy: true,
            nodes: true,
            forces: false,
            frames: None,
            parts: Spanned::new(0..0, PartsScene::default()),
        }
    }
}
