//! The `[[obstacle]]` entries of a scene file.

use super::hand::default_friction;
use super::{Length, RotationScene};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

/// An obstacle: a rigid object, such as a floor or a table, that bodies collide with and that no force moves. Tools pass through it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ObstacleScene {
    /// Name, for messages and results.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// A shape. Give either this or `mesh`.
    #[schemars(with = "Option<ObstacleShapeScene>")]
    pub shape: Option<Spanned<ObstacleShapeScene>>,
    /// Path of an OBJ file, relative to the scene.
    #[schemars(with = "Option<String>")]
    pub mesh: Option<Spanned<String>>,
    /// Length to which the longest edge of the mesh's box is scaled; the centre of the box moves to `position`.
    #[schemars(with = "Option<Length>")]
    pub size: Option<Spanned<Length>>,
    /// Metres per unit of the file, instead of `size` (0.01 if the file is in cm).
    #[schemars(with = "Option<f64>")]
    pub scale: Option<Spanned<f64>>,
    /// Distance from the surface at which bodies meet it; 0 by default. A mesh that is not closed needs it and is met from both sides.
    #[schemars(with = "Option<Length>")]
    pub thickness: Option<Spanned<Length>>,
    /// Position of the centre of the shape, of the mesh's origin or, with `size`, of the centre of its box.
    #[serde(default)]
    pub position: Option<[Length; 3]>,
    /// Rotation about `position`.
    #[serde(default)]
    pub rotation: Option<RotationScene>,
    /// Static and kinetic friction coefficient. The default, 0.35 and 0.3, is an assumption.
    #[serde(default = "default_friction")]
    #[schemars(with = "[f64; 2]")]
    pub friction: Spanned<[f64; 2]>,
    /// Coefficient of restitution: separating over approaching normal speed, 0 (default) to 1.
    #[schemars(with = "Option<f64>")]
    pub restitution: Option<Spanned<f64>>,
    /// Displacement over time: rows of time (s) and displacement along x, y and z (m), linear between the rows and constant outside.
    #[serde(default = "default_path")]
    #[schemars(with = "Vec<[f64; 4]>")]
    pub path: Spanned<Vec<[f64; 4]>>,
    /// Rotation over time: rows of time (s) and rotation vector (degrees), linear between the rows and constant outside. It is applied after `rotation`, about
    /// `position` moved along `path`.
    #[serde(default = "default_path")]
    #[schemars(with = "Vec<[f64; 4]>")]
    pub rotation_path: Spanned<Vec<[f64; 4]>>,
}

/// The shape of an obstacle.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ObstacleShapeScene {
    /// `sphere`, `capsule`, `box` or `plane`; a plane is the half-space below `position` (z is up).
    #[schemars(with = "String")]
    pub kind: Spanned<String>,
    /// Radius of a `sphere` or `capsule`.
    pub radius: Option<Length>,
    /// Length of a `capsule` between the centres of its round ends, along z.
    pub length: Option<Length>,
    /// Sides of a `box` along x, y and z.
    pub size: Option<[Length; 3]>,
}

fn default_path() -> Spanned<Vec<[f64; 4]>> {
    Spanned::new(0..0, Vec::new())
}
