//! Where hands are, and what they hold.

use super::{Damping, Force, ForceRate, Length, Mass, RotationScene, Speed, Stiffness, Toughness};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

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
    /// Radius of its tip, a sphere; a point is a small one. Either this or `shape`.
    #[schemars(with = "Option<Length>")]
    pub radius: Option<Spanned<Length>>,
    /// Its shape, if it is not a sphere.
    #[schemars(with = "Option<ToolShapeScene>")]
    pub shape: Option<Spanned<ToolShapeScene>>,
    /// Of the spring between hand and surface; by default 0.3 of the most its device renders stably.
    #[schemars(with = "Option<Stiffness>")]
    pub stiffness: Option<Spanned<Stiffness>>,
    /// Of the same; none by default.
    #[schemars(with = "Option<Damping>")]
    pub damping: Option<Spanned<Damping>>,
    /// Of its tip on sheets, which then hangs on the hand by that spring; by default the tip is where the hand is, but 10 g
    /// (an assumption) in a live run.
    #[schemars(with = "Option<Mass>")]
    pub mass: Option<Spanned<Mass>>,
    /// To start sliding, and while sliding. The default, 0.35 and 0.3, is an assumption.
    #[serde(default = "default_friction")]
    #[schemars(with = "[f64; 2]")]
    pub friction: Spanned<[f64; 2]>,
    /// Of the speed at which it meets a vertex of a sheet, what they part with; none by default.
    #[serde(default)]
    #[schemars(with = "f64")]
    pub restitution: Option<Spanned<f64>>,
    /// How it meets sheets; by default with `vertices`, on sheets too coarse for that with `triangles`.
    #[serde(default)]
    pub sheets: Option<SheetContact>,
    /// A hand that moves faster is followed at this speed.
    #[serde(default = "default_speed")]
    #[schemars(with = "Speed")]
    pub speed: Spanned<Speed>,
    /// The force on the hand changes by at most this.
    #[serde(default = "default_slew")]
    #[schemars(with = "ForceRate")]
    pub slew: Spanned<ForceRate>,
    /// Makes it a knife, for edits of kind `cut`.
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
    /// How it is turned in the axes of the hand.
    pub rotation: Option<RotationScene>,
}

/// How a tool meets a sheet.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum SheetContact {
    /// Vertices inside are held on its surface: exact, best where edges are shorter than half its radius.
    Vertices,
    /// Points of triangles are pushed out, by springs of its `stiffness` that learn the force they need.
    Triangles,
    /// A spring of its `stiffness` at each vertex inside: it stays as deep as its force needs. For comparison.
    Penalty,
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

fn default_slew() -> Spanned<ForceRate> {
    Spanned::new(0..0, ForceRate::new(500.0))
}
