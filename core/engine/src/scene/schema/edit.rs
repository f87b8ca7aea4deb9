//! What is done, and what is measured.

use super::{Force, Length, Time};
use crate::edit::{Command, Falloff};
use crate::probe::{QUANTITIES, Quantity};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use std::borrow::Cow;
use toml::Spanned;

/// What is done with a tool, and when.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct EditScene {
    /// What the edit does.
    #[schemars(with = "EditName")]
    pub kind: Spanned<EditName>,
    /// With which tool; none for `undo` and `redo`.
    #[schemars(with = "Option<String>")]
    pub tool: Option<Spanned<String>>,
    /// From when; the start by default. Of `undo` and `redo` without a `button`: when.
    #[schemars(with = "Option<Time>")]
    pub start: Option<Spanned<Time>>,
    /// Until when; the end by default.
    #[schemars(with = "Option<Time>")]
    pub end: Option<Spanned<Time>>,
    /// Only while this button is down, from 0. `undo` and `redo` happen each time a hand presses it.
    #[schemars(with = "Option<u32>")]
    pub button: Option<Spanned<u32>>,
    /// What becomes of the shape at the end; of no effect on kinds that change the shape at rest themselves.
    #[serde(default)]
    pub release: Release,
    /// A pull or grab lets go when its force is over this; 3 N by default for a pull, none for a grab.
    #[schemars(with = "Option<Force>")]
    pub limit: Option<Spanned<Force>>,
    /// Of what it acts on around the hand; three radii of the tool by default.
    #[schemars(with = "Option<Length>")]
    pub radius: Option<Spanned<Length>>,
    /// How its weight falls from the centre to the radius; `smooth` by default.
    #[schemars(with = "Option<Falloff>")]
    pub falloff: Option<Spanned<Falloff>>,
    /// Mirrors the hand in planes through the middle of the first body's box, such as `x` or `xz`; none by default.
    #[schemars(with = "Option<String>")]
    pub symmetry: Option<Spanned<String>>,
    /// How much it does, in the unit of its kind.
    #[schemars(with = "Option<Amount>")]
    pub strength: Option<Spanned<Amount>>,
}

/// A number in SI or a text with a unit, of a quantity that depends on the kind of the edit.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq)]
#[serde(untagged)]
pub enum Amount {
    /// A number in SI units.
    Number(f64),
    /// With a unit.
    Text(String),
}

/// The name of an edit kind, or `undo` or `redo`.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(transparent)]
pub struct EditName(pub String);

impl JsonSchema for EditName {
    fn schema_name() -> Cow<'static, str> {
        "EditName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let each = |(name, summary)| json_schema!({ "const": name, "description": summary });
        let names: Vec<Schema> = Command::names().map(each).collect();
        json_schema!({ "description": "What is done.", "oneOf": names })
    }
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
    #[schemars(with = "QuantityName")]
    pub quantity: Spanned<QuantityName>,
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

/// The name of a quantity.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(transparent)]
pub struct QuantityName(pub String);

impl JsonSchema for QuantityName {
    fn schema_name() -> Cow<'static, str> {
        "QuantityName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let each = |quantity: &&Quantity| json_schema!({ "const": quantity.name, "description": quantity.summary });
        let names: Vec<Schema> = QUANTITIES.iter().map(each).collect();
        json_schema!({ "description": "What a probe measures.", "oneOf": names })
    }
}
