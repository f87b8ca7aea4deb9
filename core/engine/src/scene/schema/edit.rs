//! What is done, and what is measured.

use super::{Force, Length, Time};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

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
