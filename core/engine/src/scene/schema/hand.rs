//! The `[[device]]` and `[[tool]]` entries of a scene file.

use super::{Damping, Force, ForceRate, Length, Mass, PluginScene, RotationScene, Speed, Stiffness, Toughness};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// A device, real or simulated, that moves a tool and renders its force.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DeviceScene {
    /// Name by which tools refer to the device.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Name of the device plugin, or path of its library.
    #[serde(default = "default_device")]
    #[schemars(with = "String")]
    pub plugin: Spanned<String>,
    /// Values of parameters by key.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub params: BTreeMap<String, Spanned<toml::Value>>,
    /// Recording of a session (`.rec`) instead of a plugin: its hands move the tools again, step by step, and its commands (undo, redo, sizes of the
    /// tools) are repeated. `[time] dt` must be that of the recording.
    #[schemars(with = "Option<String>")]
    pub recording: Option<Spanned<String>>,
    /// Name of the device in the recording; by default this device's name, or that of the only recorded device.
    #[schemars(with = "Option<String>")]
    pub recorded: Option<Spanned<String>>,
    /// Position, rotation and scale of the device's axes in the scene.
    #[serde(default)]
    pub frame: FrameScene,
}

fn default_device() -> Spanned<String> {
    Spanned::new(0..0, "scripted".into())
}

/// Axes of a device in the scene: given, or placed on the surface of a body by a ray.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct FrameScene {
    /// Position of the device's origin.
    pub origin: Option<[Length; 3]>,
    /// Rotation of its axes.
    pub rotation: Option<RotationScene>,
    /// Metres in the scene for each metre of the hand; 1 by default.
    #[schemars(with = "Option<f64>")]
    pub scale: Option<Spanned<f64>>,
    /// Name of a body, instead of `origin`: the origin is where a ray meets its surface, and z points back along the ray.
    #[schemars(with = "Option<String>")]
    pub body: Option<Spanned<String>>,
    /// Start of the ray, 0 to 1 along each edge of the body's box.
    pub from: Option<[f64; 3]>,
    /// A point that the ray passes through, in the same coordinates.
    pub toward: Option<[f64; 3]>,
}

/// A rigid tool that a device moves, with its shape and its virtual coupling.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ToolScene {
    /// Name by which edits refer to the tool.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Name of the device that moves it.
    #[schemars(with = "String")]
    pub device: Spanned<String>,
    /// Number of the device's effector that moves it, from 0.
    #[serde(default)]
    #[schemars(with = "u32")]
    pub effector: Option<Spanned<u32>>,
    /// Radius of a spherical tool. Give either this or `shape`.
    #[schemars(with = "Option<Length>")]
    pub radius: Option<Spanned<Length>>,
    /// Shape of a tool that is not a sphere.
    #[schemars(with = "Option<ToolShapeScene>")]
    pub shape: Option<Spanned<ToolShapeScene>>,
    /// Stiffness of the virtual coupling between hand and tool; by default 0.3 of the largest that the device renders stably.
    #[schemars(with = "Option<Stiffness>")]
    pub stiffness: Option<Spanned<Stiffness>>,
    /// Damping of the virtual coupling; none by default.
    #[schemars(with = "Option<Damping>")]
    pub damping: Option<Spanned<Damping>>,
    /// Mass of the tip on sheets, which is then driven by the virtual coupling. By default the tip follows the hand exactly; in a live run it
    /// has 10 g (an assumption).
    #[schemars(with = "Option<Mass>")]
    pub mass: Option<Spanned<Mass>>,
    /// Static and kinetic friction coefficient. The default, 0.35 and 0.3, is an assumption.
    #[serde(default = "default_friction")]
    #[schemars(with = "[f64; 2]")]
    pub friction: Spanned<[f64; 2]>,
    /// Coefficient of restitution at vertices of a sheet, 0 to 1; 0 by default.
    #[serde(default)]
    #[schemars(with = "f64")]
    pub restitution: Option<Spanned<f64>>,
    /// Contact method on sheets; by default `vertices`, or `triangles` on sheets too coarse for it.
    #[serde(default)]
    #[schemars(with = "Option<SheetContact>")]
    pub sheets: Option<Spanned<SheetContact>>,
    /// Contact law plugin and its parameters: the traction between tool and body, instead of springs, `friction` and `restitution`. On sheets it acts at
    /// vertices, with `sheets = "penalty"`.
    #[serde(default)]
    #[schemars(with = "Option<PluginScene>")]
    pub contact_law: Option<Spanned<PluginScene>>,
    /// Largest speed of the tool; a hand that moves faster is followed at this speed.
    #[serde(default = "default_speed")]
    #[schemars(with = "Speed")]
    pub speed: Spanned<Speed>,
    /// Largest rate of change of the force on the hand.
    #[serde(default = "default_slew")]
    #[schemars(with = "ForceRate")]
    pub slew: Spanned<ForceRate>,
    /// Blade of a knife, for edits of kind `cut`.
    #[schemars(with = "Option<BladeScene>")]
    pub blade: Option<Spanned<BladeScene>>,
}

/// The shape of a tool, in the axes of the hand.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ToolShapeScene {
    /// `sphere`, `capsule`, `box` or `plane`.
    #[schemars(with = "String")]
    pub kind: Spanned<String>,
    /// Radius of a `sphere` or `capsule`.
    pub radius: Option<Length>,
    /// Length of a `capsule` between the centres of its round ends, along z.
    pub length: Option<Length>,
    /// Sides of a `box` along x, y and z.
    pub size: Option<[Length; 3]>,
    /// Rotation in the axes of the hand.
    pub rotation: Option<RotationScene>,
}

/// Contact method between a tool and a sheet.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum SheetContact {
    /// Constraints: vertices that would enter the tool stay on its surface. Exact; the default where edges are at most as long as the
    /// tool's smallest dimension.
    Vertices,
    /// Augmented Lagrangian at points of triangles: springs with the tool's `stiffness`, and multipliers that are updated until no point penetrates.
    Triangles,
    /// Penalty method: a spring with the tool's `stiffness` at each vertex inside, which penetrates in proportion to the force. For comparison.
    Penalty,
}

/// The blade of a knife: a straight edge from the tip, at the position of the hand, to the heel.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BladeScene {
    /// Length of the edge.
    #[schemars(with = "Length")]
    pub length: Spanned<Length>,
    /// Direction from tip to heel, in the axes of the hand; need not be a unit vector. z by default.
    #[serde(default = "default_direction")]
    #[schemars(with = "[f64; 3]")]
    pub direction: Spanned<[f64; 3]>,
    /// Fracture toughness of a closed body: energy for each area of cut. The default, 20 J/m^2, is that of a soft gel: an assumption.
    #[serde(default = "default_toughness")]
    #[schemars(with = "Toughness")]
    pub toughness: Spanned<Toughness>,
    /// Tear strength of an open surface: energy for each length of cut, which is a force. The default, 0.2 N, is an assumption.
    #[serde(default = "default_tear")]
    #[schemars(with = "Force")]
    pub tear: Spanned<Force>,
    /// Name of the OBJ material of the faces that a cut makes inside of a body.
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

/// Static and kinetic coefficient of friction where a scene gives none: an assumption.
pub const DEFAULT_FRICTION: [f64; 2] = [0.35, 0.3];

pub(super) fn default_friction() -> Spanned<[f64; 2]> {
    Spanned::new(0..0, DEFAULT_FRICTION)
}

fn default_speed() -> Spanned<Speed> {
    Spanned::new(0..0, Speed::new(2.0))
}

fn default_slew() -> Spanned<ForceRate> {
    Spanned::new(0..0, ForceRate::new(500.0))
}
