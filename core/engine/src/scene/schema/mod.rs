//! What a scene file may say. Every field is documented here once; `pliant schema` prints it.

mod body;
mod edit;
mod grid_level;
mod hand;

pub use body::*;
pub use edit::*;
pub use grid_level::GridLevel;
pub use hand::*;

use super::units::{
    Acceleration, Angle, Damping, Force, ForceRate, Frequency, Length, Mass, Speed, Stiffness, Time, Toughness,
};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

/// A scene: what is there, what a hand does to it, and what comes out.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Scene {
    /// Version of this format: 1.
    #[schemars(with = "u32")]
    pub format: Spanned<u32>,
    /// A line for people.
    #[serde(default)]
    pub title: String,
    /// How long, and how the bodies are moved.
    #[serde(default)]
    pub time: TimeScene,
    /// The solver of implicit integrators.
    #[serde(default)]
    pub solver: SolverScene,
    /// m/s^2; none by default
    #[serde(default)]
    pub gravity: Option<[Acceleration; 3]>,
    /// What deforms.
    #[serde(default)]
    pub body: Vec<BodyScene>,
    /// Where hands are.
    #[serde(default)]
    pub device: Vec<DeviceScene>,
    /// What hands hold.
    #[serde(default)]
    pub tool: Vec<ToolScene>,
    /// What is done with the tools, and when.
    #[serde(default)]
    pub edit: Vec<EditScene>,
    /// What is measured, and what it should be.
    #[serde(default)]
    pub probe: Vec<ProbeScene>,
    /// What is written.
    #[serde(default)]
    pub output: OutputScene,
}

/// How long, and how the bodies are moved.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct TimeScene {
    /// Simulated time.
    #[schemars(with = "Time")]
    pub duration: Spanned<Time>,
    /// One step: the time between two samples of the hand.
    #[schemars(with = "Time")]
    pub dt: Spanned<Time>,
    /// `auto` takes symplectic Euler where a few substeps keep it stable, else backward Euler.
    pub integrator: IntegratorChoice,
    /// Substeps of explicit integrators; 0 takes as many as the step limit asks for.
    #[schemars(with = "u32")]
    pub substeps: Spanned<u32>,
    /// The most substeps taken before a scene is refused.
    #[schemars(with = "u32")]
    pub most_substeps: Spanned<u32>,
    /// Run an explicit integrator over its limit all the same, and report how it grows.
    pub force_unstable: bool,
    /// Wall-clock time a step of a body may take; past it the body stands still and the rest goes on.
    #[schemars(with = "Time")]
    pub patience: Spanned<Time>,
    /// Bodies slower than this for 0.1 s stand still until a tool comes near or a fixing moves. Absent, no body sleeps.
    #[schemars(with = "Option<Speed>")]
    pub sleep: Option<Spanned<Speed>>,
}

impl TimeScene {
    /// Steps of the whole run. A last step that rounding alone makes is none.
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

/// An integrator, or the choice left to the plan.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum IntegratorChoice {
    /// What the plan finds best.
    #[default]
    Auto,
    /// As printed by Qi, Zhu and Fan (2019).
    ExplicitEuler,
    /// Velocities first.
    SymplecticEuler,
    /// Linearised once a step, unless `newton` asks for more.
    BackwardEuler,
    /// Second order, damps less.
    Bdf2,
    /// Second order, damps nothing; not for contact.
    ImplicitMidpoint,
    /// Equilibrium at every step, without inertia.
    QuasiStatic,
}

/// What stands for the inverse of the matrix while it is solved with.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum PreconditionerChoice {
    /// By size, stiffness and step.
    #[default]
    Auto,
    /// Each node by itself.
    BlockJacobi,
    /// Levels of ever coarser bodies.
    Multilevel,
}

/// The solver of implicit integrators.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct SolverScene {
    /// Relative residual.
    #[schemars(with = "f64")]
    pub tolerance: Spanned<f64>,
    /// Iterations at most.
    #[schemars(with = "u32")]
    pub iterations: Spanned<u32>,
    /// Newton iterations of a step, at most: by default 1, what a hand can wait for, and 200 of `quasi-static`.
    #[schemars(with = "Option<u32>")]
    pub newton: Option<Spanned<u32>>,
    /// Of the first residual of a step, where Newton's method stops.
    #[schemars(with = "f64")]
    pub newton_tolerance: Spanned<f64>,
    /// What stands for the inverse of the matrix.
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

/// What is written.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct OutputScene {
    /// `trace.csv`, a row a step.
    pub trace: bool,
    /// Energies in the trace; they cost a pass over the elements each step.
    pub energy: bool,
    /// `nodes.csv`, the final nodes.
    pub nodes: bool,
    /// `forces.svg`, what it takes to hold nodes at the end, as arrows.
    pub forces: bool,
    /// OBJ files of the deforming surface, so many a second.
    #[schemars(with = "Option<Frequency>")]
    pub frames: Option<Spanned<Frequency>>,
}

impl Default for OutputScene {
    fn default() -> Self {
        Self { trace: true, energy: true, nodes: true, forces: false, frames: None }
    }
}
