//! What a scene file may say. Every field is documented here once; `pliant schema` prints it.

use super::units::{Acceleration, Angle, Damping, Force, Frequency, Length, Speed, Stiffness, Time, Toughness};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
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
}

impl Default for SolverScene {
    fn default() -> Self {
        Self {
            tolerance: Spanned::new(0..0, 1e-6),
            iterations: Spanned::new(0..0, 1000),
            newton: None,
            newton_tolerance: Spanned::new(0..0, 1e-6),
        }
    }
}

/// A body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BodyScene {
    /// What other parts of the scene call it.
    #[serde(default = "default_body")]
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// An OBJ file, relative to the scene.
    #[schemars(with = "Option<String>")]
    pub mesh: Option<Spanned<String>>,
    /// Or a shape made here.
    #[schemars(with = "Option<ShapeScene>")]
    pub shape: Option<Spanned<ShapeScene>>,
    /// Scales the longest edge of its box to this and its centre to `position`.
    #[schemars(with = "Option<Length>")]
    pub size: Option<Spanned<Length>>,
    /// Or metres for a unit of the file.
    #[schemars(with = "Option<f64>")]
    pub scale: Option<Spanned<f64>>,
    /// Where its origin, or with `size` its centre, is.
    #[serde(default)]
    pub position: Option<[Length; 3]>,
    /// How it is turned.
    #[serde(default)]
    pub rotation: Option<RotationScene>,
    /// What the force is.
    pub material: PluginScene,
    /// Which nodes carry it.
    #[serde(default)]
    pub grid: GridScene,
    /// Its own vertices carry it instead: for cloth and other thin shells.
    #[schemars(with = "Option<SheetScene>")]
    pub sheet: Option<Spanned<SheetScene>>,
    /// Nodes that are held or led.
    #[serde(default)]
    #[schemars(with = "Vec<FixedScene>")]
    pub fixed: Vec<Spanned<FixedScene>>,
}

fn default_body() -> Spanned<String> {
    Spanned::new(0..0, "body".into())
}

/// A shape made by the program.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ShapeScene {
    /// Which.
    pub kind: ShapeKind,
    /// Cells along an edge, around the equator quarter, or around the cylinder.
    #[serde(default = "default_cells")]
    pub cells: u32,
    /// Edges of a box; of a sphere or cylinder the first is the diameter, the last the height; a sheet has its width along x,
    /// its height along y, and no third.
    pub size: [Length; 3],
    /// Cells of a sheet along y; by default as high as they are wide.
    #[serde(default)]
    pub rows: u32,
    /// How a sheet is cut into triangles.
    #[serde(default)]
    pub pattern: PatternScene,
}

fn default_cells() -> u32 {
    16
}

/// Shapes there are.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum ShapeKind {
    /// A closed box of quads.
    Box,
    /// A closed sphere of quads.
    Sphere,
    /// A closed cylinder along z.
    Cylinder,
    /// A flat sheet in the plane z = 0, its lower left corner in the origin.
    Sheet,
}

/// Ways a sheet is cut into triangles.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum PatternScene {
    /// Diagonals change direction from cell to cell.
    #[default]
    Alternating,
    /// All diagonals run one way.
    Regular,
    /// Every second row is moved by half a cell.
    Equilateral,
    /// Regular, with the inner vertices moved at random, the same in every run.
    Irregular,
}

/// A turn about an axis through the origin.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RotationScene {
    /// Need not be a unit vector.
    #[schemars(with = "[f64; 3]")]
    pub axis: Spanned<[f64; 3]>,
    /// Counter-clockwise seen from its tip.
    pub angle: Angle,
}

/// A plugin and its parameters.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PluginScene {
    /// Its name, or a path to its library.
    #[schemars(with = "String")]
    pub plugin: Spanned<String>,
    /// Values by key; numbers in the parameter's unit or texts with a unit. `pliant plugin info` lists them.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub params: BTreeMap<String, Spanned<toml::Value>>,
}

/// A body carried by its own mesh.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SheetScene {
    /// Where the warp runs: a direction in the placed rest shape, in the plane of each triangle, or `"texture"`, along u of
    /// the texture coordinates.
    #[serde(default)]
    pub warp: WarpScene,
}

/// Where the warp runs.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum WarpScene {
    /// A direction.
    Axis([f64; 3]),
    /// By name.
    Name(WarpName),
}

/// Ways a warp may run.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WarpName {
    /// Along u.
    Texture,
}

impl Default for WarpScene {
    fn default() -> Self {
        Self::Axis([1.0, 0.0, 0.0])
    }
}

/// The grid of a body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct GridScene {
    /// Its name, or a path to its library.
    #[schemars(with = "String")]
    pub plugin: Spanned<String>,
    /// Values by key.
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub params: BTreeMap<String, Spanned<toml::Value>>,
    /// Level that is simulated: 2^(level - 1) cells along each axis.
    #[schemars(with = "u32")]
    pub level: Spanned<u32>,
    /// `local`: the cells around each contact; `whole`: all of them.
    pub region: Extent,
    /// Radius of a local region; 10 cells by default.
    #[schemars(with = "Option<Length>")]
    pub radius: Option<Spanned<Length>>,
    /// Time constant of the return to rest of what a tool has left behind.
    #[schemars(with = "Time")]
    pub relaxation: Spanned<Time>,
}

impl Default for GridScene {
    fn default() -> Self {
        Self {
            plugin: Spanned::new(0..0, "octree-grid".into()),
            params: BTreeMap::new(),
            level: Spanned::new(0..0, 6),
            region: Extent::Local,
            radius: None,
            relaxation: Spanned::new(0..0, Time::new(0.01)),
        }
    }
}

/// How much of a body is simulated.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Extent {
    /// Around each contact.
    Local,
    /// Everything.
    Whole,
}

/// Nodes that are held, or led along a path. Give one of `box`, `ball` and `nodes`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FixedScene {
    /// Least and greatest corner, in the scene.
    #[serde(rename = "box")]
    pub box_: Option<[[Length; 3]; 2]>,
    /// Centre.
    pub ball: Option<[Length; 3]>,
    /// Radius of the ball.
    pub radius: Option<Length>,
    /// Numbers of nodes; of a whole region only.
    pub nodes: Option<Vec<u32>>,
    /// Of a sheet: edges of its border whose ends are both held keep the direction they have at rest.
    #[serde(default)]
    pub clamp: bool,
    /// Rows of time (s) and displacement (m): linear between, constant outside.
    #[serde(default)]
    pub path: Vec<[f64; 4]>,
}

/// A device.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DeviceScene {
    /// What tools call it.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Its plugin.
    #[serde(default = "default_device")]
    #[schemars(with = "String")]
    pub plugin: Spanned<String>,
    /// Values by key.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub params: BTreeMap<String, Spanned<toml::Value>>,
    /// Where its axes are in the scene.
    #[serde(default)]
    pub frame: FrameScene,
}

fn default_device() -> Spanned<String> {
    Spanned::new(0..0, "scripted".into())
}

/// A device's axes in the scene: given, or standing on the surface of a body.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct FrameScene {
    /// Where the device's origin is.
    pub origin: Option<[Length; 3]>,
    /// How its axes are turned.
    pub rotation: Option<RotationScene>,
    /// Metres in the scene for a metre of the hand; 1 by default.
    #[schemars(with = "Option<f64>")]
    pub scale: Option<Spanned<f64>>,
    /// Or: the origin is where a ray meets this body, and z points back along the ray.
    #[schemars(with = "Option<String>")]
    pub body: Option<Spanned<String>>,
    /// Where the ray starts, 0 to 1 along each edge of the body's box.
    pub from: Option<[f64; 3]>,
    /// What it goes towards, likewise.
    pub toward: Option<[f64; 3]>,
}

/// A tool.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ToolScene {
    /// What edits call it.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// The device that moves it.
    #[schemars(with = "String")]
    pub device: Spanned<String>,
    /// Which effector of the device, from 0.
    #[serde(default)]
    #[schemars(with = "u32")]
    pub effector: Option<Spanned<u32>>,
    /// Radius of its tip; a point is a small ball.
    #[schemars(with = "Length")]
    pub radius: Spanned<Length>,
    /// Of the spring between hand and surface; by default 0.3 of the most its device renders stably.
    #[schemars(with = "Option<Stiffness>")]
    pub stiffness: Option<Spanned<Stiffness>>,
    /// Of the same; none by default.
    #[schemars(with = "Option<Damping>")]
    pub damping: Option<Spanned<Damping>>,
    /// To start sliding, and while sliding. The default, 0.35 and 0.3, is an assumption.
    #[serde(default = "default_friction")]
    #[schemars(with = "[f64; 2]")]
    pub friction: Spanned<[f64; 2]>,
    /// A hand that moves faster is followed at this speed.
    #[serde(default = "default_speed")]
    #[schemars(with = "Speed")]
    pub speed: Spanned<Speed>,
    /// The force on the hand changes by at most this.
    #[serde(default = "default_slew")]
    #[schemars(with = "super::units::ForceRate")]
    pub slew: Spanned<super::units::ForceRate>,
    /// Makes it a knife, for edits of kind `cut`.
    #[schemars(with = "Option<BladeScene>")]
    pub blade: Option<Spanned<BladeScene>>,
}

/// The blade of a knife: a straight edge from the tip, which is where the hand is.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BladeScene {
    /// Of its edge.
    #[schemars(with = "Length")]
    pub length: Spanned<Length>,
    /// From tip to heel, in the axes of the hand; need not be a unit vector. z by default.
    #[serde(default = "default_direction")]
    #[schemars(with = "[f64; 3]")]
    pub direction: Spanned<[f64; 3]>,
    /// Energy of a new area of cut inside of a closed body. The default, 20 J/m^2, is that of a soft gel: an assumption.
    #[serde(default = "default_toughness")]
    #[schemars(with = "Toughness")]
    pub toughness: Spanned<Toughness>,
    /// Force against a cut through an open surface: energy of a length of new edge. The default, 0.2 N, is an assumption.
    #[serde(default = "default_tear")]
    #[schemars(with = "Force")]
    pub tear: Spanned<Force>,
    /// Name of the material of the faces a cut makes inside of a body.
    #[serde(default = "default_cap")]
    #[schemars(with = "String")]
    pub material: Spanned<String>,
}

fn default_direction() -> Spanned<[f64; 3]> {
    Spanned::new(0..0, [0.0, 0.0, 1.0])
}

fn default_toughness() -> Spanned<Toughness> {
    Spanned::new(0..0, Toughness::new(20.0))
}

fn default_tear() -> Spanned<Force> {
    Spanned::new(0..0, Force::new(0.2))
}

fn default_cap() -> Spanned<String> {
    Spanned::new(0..0, "cut".into())
}

fn default_friction() -> Spanned<[f64; 2]> {
    Spanned::new(0..0, [0.35, 0.3])
}

fn default_speed() -> Spanned<Speed> {
    Spanned::new(0..0, Speed::new(2.0))
}

fn default_slew() -> Spanned<super::units::ForceRate> {
    Spanned::new(0..0, super::units::ForceRate::new(500.0))
}

/// What is done with a tool, and when.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct EditScene {
    /// What.
    pub kind: EditKind,
    /// With which tool; none for `undo` and `redo`.
    #[schemars(with = "Option<String>")]
    pub tool: Option<Spanned<String>>,
    /// From when; the start by default. When, of `undo` and `redo`.
    #[schemars(with = "Option<Time>")]
    pub start: Option<Spanned<Time>>,
    /// Until when; the end by default.
    #[schemars(with = "Option<Time>")]
    pub end: Option<Spanned<Time>>,
    /// Only while this button is down, from 0.
    #[schemars(with = "Option<u32>")]
    pub button: Option<Spanned<u32>>,
    /// What becomes of the shape at the end.
    #[serde(default)]
    pub release: Release,
    /// A pull lets go when its force is over this; 3 N by default.
    #[schemars(with = "Option<Force>")]
    pub limit: Option<Spanned<Force>>,
}

/// Edits there are.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum EditKind {
    /// Slide over surfaces and press them.
    Touch,
    /// Take hold of a point.
    Pull,
    /// Cut with a tool that has a blade.
    Cut,
    /// Take back the last cut, or the last edit whose shape was kept.
    Undo,
    /// Make again what was taken back last.
    Redo,
}

/// What becomes of the shape at the end of an edit.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Release {
    /// It goes back.
    #[default]
    SpringBack,
    /// It becomes the new rest shape.
    Keep,
}

/// Something measured, and what it should be.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ProbeScene {
    /// A name for the report.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// What is measured.
    pub quantity: ProbeQuantity,
    /// Of which tool or body; the first by default.
    #[schemars(with = "Option<String>")]
    pub of: Option<Spanned<String>>,
    /// Of the surface point nearest to this.
    pub at: Option<[Length; 3]>,
    /// When; the end by default.
    #[schemars(with = "Option<Time>")]
    pub time: Option<Spanned<Time>>,
    /// The greatest until then, instead of the value then.
    #[serde(default)]
    pub greatest: bool,
    /// What it should be, in SI.
    #[schemars(with = "Option<f64>")]
    pub expected: Option<Spanned<f64>>,
    /// How far off it may be, relative to what it should be; 1 % by default.
    #[serde(default = "default_tolerance")]
    #[schemars(with = "f64")]
    pub tolerance: Spanned<f64>,
    /// Where the expected value comes from.
    #[serde(default)]
    pub source: String,
}

fn default_tolerance() -> Spanned<f64> {
    Spanned::new(0..0, 0.01)
}

/// What a probe measures.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum ProbeQuantity {
    /// N, of the force on the hand, before what keeps it safe.
    Force,
    /// m, how far the surface is pushed in, or out, at the contact.
    Depth,
    /// m, of a surface point from where it was handed in.
    Displacement,
    /// J
    KineticEnergy,
    /// J
    ElasticEnergy,
    /// How many parts a body hangs together in.
    Parts,
    /// m^2, of what blades have cut inside of closed bodies, one wall of two.
    CutArea,
    /// m, of the edge blades have cut into surfaces, one side of two.
    CutLength,
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
    /// OBJ files of the deforming surface, so many a second.
    #[schemars(with = "Option<Frequency>")]
    pub frames: Option<Spanned<Frequency>>,
}

impl Default for OutputScene {
    fn default() -> Self {
        Self { trace: true, energy: true, nodes: true, frames: None }
    }
}
