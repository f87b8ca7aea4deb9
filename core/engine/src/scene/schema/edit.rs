//! The `[[edit]]` and `[[probe]]` entries of a scene file.

use super::{Force, Length, Time};
use crate::edit::{Command, Falloff, SheetLayers};
use crate::probe::{QUANTITIES, Quantity};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use std::borrow::Cow;
use toml::Spanned;

/// An edit: what is done with a tool, and when.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct EditScene {
    /// Kind of the edit, such as `touch` or `cut`.
    #[schemars(with = "EditName")]
    pub kind: Spanned<EditName>,
    /// Name of the tool; absent for `undo` and `redo`.
    #[schemars(with = "Option<String>")]
    pub tool: Option<Spanned<String>>,
    /// Time at which the edit starts; 0 by default. For `undo` and `redo` without a `button`, the time at which they happen.
    #[schemars(with = "Option<Time>")]
    pub start: Option<Spanned<Time>>,
    /// Time at which the edit ends; the end of the scene by default.
    #[schemars(with = "Option<Time>")]
    pub end: Option<Spanned<Time>>,
    /// Number of a button, from 0: the edit acts only while it is down. `undo` and `redo` happen each time a hand presses it.
    #[schemars(with = "Option<u32>")]
    pub button: Option<Spanned<u32>>,
    /// What happens to the shape at the end of the edit; without effect on kinds that change the rest shape themselves.
    #[serde(default)]
    pub release: Release,
    /// Force above which a pull or grab lets go; 3 N by default for a pull, no limit for a grab.
    #[schemars(with = "Option<Force>")]
    pub limit: Option<Spanned<Force>>,
    /// Radius of the region around the hand on which the edit acts; three radii of the tool by default.
    #[schemars(with = "Option<Length>")]
    pub radius: Option<Spanned<Length>>,
    /// How the weight of the edit decreases from the centre to the radius; `smooth` by default.
    #[schemars(with = "Option<Falloff>")]
    pub falloff: Option<Spanned<Falloff>>,
    /// Planes in which the hand is mirrored: `x` or `xz`, `{ own = "x" }`, or `{ point = [0, 0, 0], normal = [1, 1, 0] }`; none by default.
    #[schemars(with = "Option<SymmetryScene>")]
    pub symmetry: Option<Spanned<SymmetryScene>>,
    /// Strength of the edit, in the unit of its kind.
    #[schemars(with = "Option<Amount>")]
    pub strength: Option<Spanned<Amount>>,
    /// Parameter of the material that a `paint` changes, such as `density`; `young`, the stiffness, by default.
    #[schemars(with = "Option<String>")]
    pub param: Option<Spanned<String>>,
    /// Depth to which a `paint` changes the material: `through` (default), `surface`, or the thickness of a layer in m.
    #[schemars(with = "Option<Amount>")]
    pub depth: Option<Spanned<Amount>>,
    /// Whether each part of the bodies that a `cut` has cut becomes a body of its own at the end of the edit; `false` by default.
    #[schemars(with = "Option<bool>")]
    pub split: Option<Spanned<bool>>,
    /// SheetLayers of a sheet that a `cut` cuts: `one` (default), as the blade moves and against resistance, or `all` that it has swept, at the end of the edit.
    #[schemars(with = "Option<SheetLayers>")]
    pub sheet_layers: Option<Spanned<SheetLayers>>,
}

/// Planes in which a hand is mirrored.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "axes such as \"x\" or \"xz\", `{ own = \"x\" }`, or `{ point = [0, 0, 0], normal = [1, 0, 0] }`"
)]
pub enum SymmetryScene {
    /// Axes of the scene, one or more of x, y and z: the planes normal to them through the middle of the first body's box.
    Axes(String),
    /// A plane of the first body's model, which turns with the body's `rotation`.
    Own {
        /// Axis of the model, x, y or z: the plane is normal to it and goes through the middle of the model's box in its file.
        own: String,
    },
    /// A plane of the scene.
    Plane {
        /// A point on the plane.
        point: [Length; 3],
        /// Normal of the plane, of any length above 0.
        normal: [f64; 3],
    },
}

/// A number in SI units or a text with a unit; the quantity depends on the kind of the edit.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq)]
#[serde(untagged)]
pub enum Amount {
    /// A number in SI units.
    Number(f64),
    /// A text with a unit.
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
        let schema_of = |(name, summary)| json_schema!({ "const": name, "description": summary });
        let names: Vec<Schema> = Command::names().map(schema_of).collect();
        json_schema!({ "description": "Kind of the edit.", "oneOf": names })
    }
}

/// What happens to the shape at the end of an edit.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Release {
    /// The body returns to the rest shape.
    #[default]
    SpringBack,
    /// The present shape becomes the new rest shape.
    Keep,
}

/// A quantity that is measured, and its expected value.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ProbeScene {
    /// Name in the summary.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Quantity that is measured, such as `force` or `displacement`.
    #[schemars(with = "QuantityName")]
    pub quantity: Spanned<QuantityName>,
    /// Name of the tool or body of which it is measured; the first by default.
    #[schemars(with = "Option<String>")]
    pub of: Option<Spanned<String>>,
    /// Point to which the measured surface point is the nearest.
    pub at: Option<[Length; 3]>,
    /// Direction, of any length, along which the component of a `displacement`, `force`, `torque`, `obstacle-force` or `contact-force` is measured, with
    /// its sign; the length of the vector by default.
    #[schemars(with = "Option<[f64; 3]>")]
    pub direction: Option<Spanned<[f64; 3]>>,
    /// Time of the measurement; the end of the scene by default.
    #[schemars(with = "Option<Time>")]
    pub time: Option<Spanned<Time>>,
    /// Whether the largest value up to that time is measured, instead of the value at that time.
    #[serde(default)]
    pub greatest: bool,
    /// Expected value, in SI units.
    #[schemars(with = "Option<f64>")]
    pub expected: Option<Spanned<f64>>,
    /// Allowed error relative to the expected value; 1 % by default.
    #[serde(default = "default_tolerance")]
    #[schemars(with = "f64")]
    pub tolerance: Spanned<f64>,
    /// Source of the expected value.
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
        let schema_of =
            |quantity: &&Quantity| json_schema!({ "const": quantity.name, "description": quantity.summary });
        let names: Vec<Schema> = QUANTITIES.iter().map(schema_of).collect();
        json_schema!({ "description": "What a probe measures.", "oneOf": names })
    }
}
