//! The `[[body.fibre]]` entries of a scene file.

use super::{Angle, Length};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

/// Directions of the fibres of a solid. Give one of `direction`, `around`, `along` and `csv`; with a `box`, a `ball` and `radius` or a `group`, in that
/// place alone. Where several entries apply, the last one counts; where none does, there are no fibres.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FibreScene {
    /// One direction; need not be a unit vector, and its sign has no meaning.
    #[schemars(with = "Option<[f64; 3]>")]
    pub direction: Option<Spanned<[f64; 3]>>,
    /// Circles or helices around an axis.
    #[schemars(with = "Option<AroundScene>")]
    pub around: Option<Spanned<AroundScene>>,
    /// Points of a curve, 2 or more: a fibre has the direction of the curve at its nearest point.
    #[schemars(with = "Option<Vec<[Length; 3]>>")]
    pub along: Option<Spanned<Vec<[Length; 3]>>>,
    /// Path, relative to the scene, of a file with a point and a direction in each line: `x, y, z, dx, dy, dz`. Directions between points are weighted means.
    #[schemars(with = "Option<String>")]
    pub csv: Option<Spanned<String>>,
    /// Axes of directions and points: those of the scene, or those of the model before `position`, `rotation`, `size` and `scale`.
    #[serde(default)]
    pub axes: FibreAxes,
    /// A box, by the corners with the least and the greatest coordinates in the scene.
    #[serde(rename = "box")]
    pub box_: Option<[[Length; 3]; 2]>,
    /// Centre of a ball in the scene.
    pub ball: Option<[Length; 3]>,
    /// Radius of the ball.
    pub radius: Option<Length>,
    /// A name of `g` or `o` lines of the OBJ file: material nearest to its faces.
    #[schemars(with = "Option<String>")]
    pub group: Option<Spanned<String>>,
}

/// Fibres around an axis.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct AroundScene {
    /// Direction of the axis; need not be a unit vector.
    pub axis: [f64; 3],
    /// A point of the axis.
    #[schemars(with = "[Length; 3]")]
    pub point: Spanned<[Length; 3]>,
    /// Angle from the circle towards the axis: 0, the default, gives circles, a positive one right-handed helices, 90 deg lines along the axis.
    #[serde(default = "no_angle")]
    pub helix_angle: Angle,
}

fn no_angle() -> Angle {
    Angle::new(0.0)
}

/// Axes in which fibres are given.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum FibreAxes {
    /// Axes of the scene, with the body at rest.
    #[default]
    Scene,
    /// Axes of the model in its file; points are in units of the file.
    Model,
}
