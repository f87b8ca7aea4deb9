//! What deforms.

use super::{Angle, GridLevel, Length, Time};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

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
    /// Or metres per file unit (0.01 if the file is in cm).
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
    /// Where parameters of the material differ; later entries multiply earlier ones.
    #[serde(default)]
    #[schemars(with = "Vec<FieldScene>")]
    pub field: Vec<Spanned<FieldScene>>,
}

fn default_body() -> Spanned<String> {
    Spanned::new(0..0, "body".into())
}

/// A shape made by the program.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ShapeScene {
    /// Kind of shape.
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
    /// A direction given by name.
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
    /// Level that is simulated: 2^(level - 1) cells along the longest edge of the body, or `auto`.
    #[schemars(with = "GridLevel")]
    pub level: Spanned<GridLevel>,
    /// `local`: the cells around each contact; `whole`: all of them.
    pub region: Extent,
    /// Radius of a local region; 10 cells by default.
    #[schemars(with = "Option<Length>")]
    pub radius: Option<Spanned<Length>>,
    /// Time constant of the return to rest of what a tool has left behind.
    #[schemars(with = "Time")]
    pub relaxation: Spanned<Time>,
    /// Whether the surface follows the nodes with continuous slopes; `false`: by trilinear weights, with creases along the cells.
    pub smooth: bool,
}

impl Default for GridScene {
    fn default() -> Self {
        Self {
            plugin: Spanned::new(0..0, "octree-grid".into()),
            params: BTreeMap::new(),
            level: Spanned::new(0..0, GridLevel::Auto),
            region: Extent::Local,
            radius: None,
            relaxation: Spanned::new(0..0, Time::new(0.01)),
            smooth: true,
        }
    }
}

/// How much of a body is simulated.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Extent {
    /// Around each contact.
    Local,
    /// The whole body is simulated.
    Whole,
}

/// Nodes that are held, or led along a path. Give one of `box`, `ball`, `group` and `nodes`.
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
    /// A name of `g` or `o` lines of the OBJ: the vertices of its faces, of a solid the corners of the cells they go through.
    #[schemars(with = "Option<String>")]
    pub group: Option<Spanned<String>>,
    /// Numbers of nodes; of a whole region only.
    pub nodes: Option<Vec<u32>>,
    /// Of a sheet: edges of its border whose ends are both held keep the direction they have at rest.
    #[serde(default)]
    pub clamp: bool,
    /// Rows of time (s) and displacement (m): linear between, constant outside.
    #[serde(default)]
    pub path: Vec<[f64; 4]>,
}

/// A factor of a parameter of the material that differs from place to place. Give one of `box`, `ball`, `group`, `colour`, `csv`
/// and `texture`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FieldScene {
    /// Key of the parameter; `pliant plugin info` tells which may differ.
    #[schemars(with = "String")]
    pub param: Spanned<String>,
    /// Factor within the box, ball or group, 0.1 to 10; 1 elsewhere.
    #[schemars(with = "Option<f64>")]
    pub factor: Option<Spanned<f64>>,
    /// Least and greatest corner, in the scene.
    #[serde(rename = "box")]
    pub box_: Option<[[Length; 3]; 2]>,
    /// Centre.
    pub ball: Option<[Length; 3]>,
    /// Radius of the ball.
    pub radius: Option<Length>,
    /// What lies nearest to the faces with this name of `g` or `o` lines of the OBJ.
    #[schemars(with = "Option<String>")]
    pub group: Option<Spanned<String>>,
    /// A channel of the colours of the vertices (`v x y z r g b`), 0 to 1, as at the nearest place of the surface.
    pub colour: Option<Channel>,
    /// Factors at 0 and 1 of the channel or the texture, geometric between; 0.1 and 10 by default.
    pub range: Option<[f64; 2]>,
    /// A file with one factor a line for each vertex, relative to the scene, as at the nearest place of the surface.
    #[schemars(with = "Option<String>")]
    pub csv: Option<Spanned<String>>,
    /// A grey PNG image, relative to the scene, by the texture coordinates (`vt`) at the nearest place of the surface.
    #[schemars(with = "Option<String>")]
    pub texture: Option<Spanned<String>>,
}

impl FieldScene {
    /// The file it reads, relative to the scene.
    pub fn file(&self) -> Option<&Spanned<String>> {
        self.csv.as_ref().or(self.texture.as_ref())
    }
}

/// Channels of a colour.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Channel {
    /// The first of the three numbers after the coordinates of a vertex.
    Red,
    /// The second of them.
    Green,
    /// The third of them.
    Blue,
}
