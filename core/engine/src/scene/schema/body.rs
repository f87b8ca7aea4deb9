//! The `[[body]]` entries of a scene file: model, material, discretization, fixings and fields.

use super::{Angle, FibreScene, Length, Level, SeamScene, Time, Weld};
use pliant_mesh::TetMesh;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// A deformable body: its model, its material and how it is discretised.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BodyScene {
    /// Name by which other entries of the scene refer to the body.
    #[serde(default = "default_body")]
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Path of the file of the model, relative to the scene: an OBJ file, or a tetrahedral mesh (`.msh` of Gmsh, legacy `.vtk` or `.vtu`), which is simulated as it is. Give
    /// either this or `shape`.
    #[schemars(with = "Option<String>")]
    pub mesh: Option<Spanned<String>>,
    /// A generated model.
    #[schemars(with = "Option<ShapeScene>")]
    pub shape: Option<Spanned<ShapeScene>>,
    /// Length to which the longest edge of the model's box is scaled; the centre of the box moves to `position`.
    #[schemars(with = "Option<Length>")]
    pub size: Option<Spanned<Length>>,
    /// Metres per unit of the file, instead of `size` (0.01 if the file is in cm).
    #[schemars(with = "Option<f64>")]
    pub scale: Option<Spanned<f64>>,
    /// Number of times that every face is divided into four before the model is used, or `auto` for edges of at most half the radius of the smallest
    /// tool. Files of results have the divided faces.
    #[schemars(with = "Option<Level>")]
    pub subdivide: Option<Spanned<Level>>,
    /// Whether vertices of borders that lie at one place become one, where borders continue each other; or a length, up to which they lie at one place. `true` by default for a file
    /// whose borders are not cuts and without `stitch`. The lines of the file stay.
    #[schemars(with = "Option<Weld>")]
    pub weld: Option<Spanned<Weld>>,
    /// Position of the model's origin or, with `size`, of the centre of its box.
    #[serde(default)]
    pub position: Option<[Length; 3]>,
    /// Rotation of the model.
    #[serde(default)]
    pub rotation: Option<RotationScene>,
    /// Material plugin and its parameters.
    pub material: PluginScene,
    /// Grid in which a solid is embedded.
    #[serde(default = "default_grid")]
    #[schemars(with = "GridScene")]
    pub grid: Spanned<GridScene>,
    /// Simulates the model on its own mesh instead of in a grid: for cloth and other thin shells.
    #[schemars(with = "Option<SheetScene>")]
    pub sheet: Option<Spanned<SheetScene>>,
    /// Nodes that are held or driven along a path.
    #[serde(default)]
    #[schemars(with = "Vec<FixedScene>")]
    pub fixed: Vec<Spanned<FixedScene>>,
    /// Factors of material parameters that vary over the body; factors of several entries multiply.
    #[serde(default)]
    #[schemars(with = "Vec<FieldScene>")]
    pub field: Vec<Spanned<FieldScene>>,
    /// Directions of the fibres of a solid whose material takes them; where several entries apply, the last one counts.
    #[serde(default)]
    #[schemars(with = "Vec<FibreScene>")]
    pub fibre: Vec<Spanned<FibreScene>>,
    /// Seams of a sheet, as of a sewing pattern, closed from the start.
    #[serde(default)]
    #[schemars(with = "Vec<SeamScene>")]
    pub stitch: Vec<Spanned<SeamScene>>,
    /// Whether it collides with the other bodies whose `meets` is `true`; `false` by default.
    #[schemars(with = "Option<bool>")]
    pub meets: Option<Spanned<bool>>,
    /// Whether a sheet collides with itself; `false` by default.
    #[schemars(with = "Option<bool>")]
    pub self_contact: Option<Spanned<bool>>,
    /// Static and kinetic friction coefficient on other bodies and on itself; between two bodies the smaller ones apply. The default, 0.35 and 0.3, is an
    /// assumption.
    #[schemars(with = "Option<[f64; 2]>")]
    pub friction: Option<Spanned<[f64; 2]>>,
}

impl BodyScene {
    /// Whether the model is a tetrahedral mesh, by the ending of its file's name.
    pub fn is_tetrahedral(&self) -> bool {
        self.mesh.as_ref().is_some_and(|mesh| TetMesh::is_name(mesh.get_ref()))
    }

    /// Whether the body is simulated on its own mesh, without a grid: a sheet, or a tetrahedral mesh.
    pub fn has_own_mesh(&self) -> bool {
        self.sheet.is_some() || self.is_tetrahedral()
    }

    /// Which cells or elements are simulated: all of a body that is simulated on its own mesh.
    pub fn extent(&self) -> Extent {
        if self.has_own_mesh() { Extent::Whole } else { self.grid.get_ref().region }
    }
}

fn default_grid() -> Spanned<GridScene> {
    Spanned::new(0..0, GridScene::default())
}

fn default_body() -> Spanned<String> {
    Spanned::new(0..0, "body".into())
}

/// A generated model.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ShapeScene {
    /// Kind of shape.
    pub kind: ShapeKind,
    /// Number of cells along an edge of a box or sheet, along a quarter of a sphere's equator, or around a cylinder.
    #[serde(default = "default_cells")]
    pub cells: u32,
    /// Edges of a box along x, y and z. For a sphere or cylinder the first is the diameter and the last the height; a sheet has its width along
    /// x and its height along y, and does not use the third.
    pub size: [Length; 3],
    /// Number of cells of a sheet along y; 0, the default, makes cells about square.
    #[serde(default)]
    pub rows: u32,
    /// How a sheet is divided into triangles.
    #[serde(default)]
    pub pattern: PatternScene,
}

fn default_cells() -> u32 {
    16
}

/// Kinds of generated models.
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

/// Triangulations of a sheet.
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

/// A rotation about an axis through the origin.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RotationScene {
    /// Axis of the rotation; need not be a unit vector.
    #[schemars(with = "[f64; 3]")]
    pub axis: Spanned<[f64; 3]>,
    /// Angle of the rotation, counter-clockwise seen from the tip of the axis.
    pub angle: Angle,
}

/// A plugin and its parameters.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PluginScene {
    /// Name of the plugin, or path of its library.
    #[schemars(with = "String")]
    pub plugin: Spanned<String>,
    /// Values of parameters by key: numbers in the parameter's unit or texts with a unit. `pliant plugin info` lists the keys.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub params: BTreeMap<String, Spanned<toml::Value>>,
}

/// Settings of a body that is simulated on its own mesh.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SheetScene {
    /// Direction of the warp threads: a vector in the placed rest shape, projected onto the plane of each triangle, or `"texture"` for the
    /// direction of u of the texture coordinates.
    #[serde(default)]
    pub warp: WarpScene,
}

/// Direction of the warp threads.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum WarpScene {
    /// A vector in the placed rest shape, of any length above 0.
    Axis([f64; 3]),
    /// A direction given by name.
    Name(WarpName),
}

/// Named directions of the warp threads.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WarpName {
    /// Along u of the texture coordinates.
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
    /// Name of the grid plugin, or path of its library.
    #[schemars(with = "String")]
    pub plugin: Spanned<String>,
    /// Values of parameters by key.
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub params: BTreeMap<String, Spanned<toml::Value>>,
    /// Grid level that is simulated: 2^(level - 1) cells along the longest edge of the body, or `auto`.
    #[schemars(with = "Level")]
    pub level: Spanned<Level>,
    /// Which cells are simulated: those around contacts (`local`) or all (`whole`).
    pub region: Extent,
    /// Radius of a local region; by default the larger of 10 cells and 4 radii of the largest tool.
    #[schemars(with = "Option<Length>")]
    pub radius: Option<Spanned<Length>>,
    /// Time constant with which cells return to rest after a tool has left them.
    #[schemars(with = "Time")]
    pub relaxation: Spanned<Time>,
    /// Whether the surface is interpolated from the nodes with continuous slopes; `true` by default. `false` uses trilinear weights, which show creases along
    /// the cells. Bodies whose material can fail have trilinear weights, because slopes would continue across cracks.
    #[schemars(with = "Option<bool>")]
    pub smooth: Option<Spanned<bool>>,
}

impl Default for GridScene {
    fn default() -> Self {
        Self {
            plugin: Spanned::new(0..0, "octree-grid".into()),
            params: BTreeMap::new(),
            level: Spanned::new(0..0, Level::Auto),
            region: Extent::Local,
            radius: None,
            relaxation: Spanned::new(0..0, Time::new(0.01)),
            smooth: None,
        }
    }
}

/// Which cells of a body are simulated.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Extent {
    /// The cells around each contact.
    Local,
    /// All cells.
    Whole,
}

/// Nodes that are held, or driven along a path. Give one of `box`, `ball`, `group` and `nodes`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FixedScene {
    /// A box, by the corners with the least and the greatest coordinates in the scene: nodes within it.
    #[serde(rename = "box")]
    pub box_: Option<[[Length; 3]; 2]>,
    /// Centre of a ball in the scene: nodes within it.
    pub ball: Option<[Length; 3]>,
    /// Radius of the ball.
    pub radius: Option<Length>,
    /// A name of `g` or `o` lines of the OBJ file: the vertices of its faces, or for a solid the corners of the cells that contain its faces. For a tetrahedral
    /// mesh a physical group: its nodes.
    #[schemars(with = "Option<String>")]
    pub group: Option<Spanned<String>>,
    /// A channel of the vertex colours (`v x y z r g b`), 0 to 1: what has at least the value `above`, with the channel linear within triangles. Of a sheet these are
    /// vertices, of a solid the corners of the cells that this part of the surface goes through.
    pub colour: Option<Channel>,
    /// A grey PNG image, relative to the scene, by the texture coordinates (`vt`) of the OBJ: the same with its values, black 0 and white 1.
    #[schemars(with = "Option<String>")]
    pub texture: Option<Spanned<String>>,
    /// Value of `colour` or `texture` from which on nodes are held, above 0 and at most 1; 0.5 by default.
    #[schemars(with = "Option<f64>")]
    pub above: Option<Spanned<f64>>,
    /// Numbers of nodes; for a whole region only. For a tetrahedral mesh they are those of the file: tags in a `.msh`, positions from 0 in a `.vtk`.
    pub nodes: Option<Vec<u32>>,
    /// For a sheet: whether border edges with both ends held are clamped, which keeps their direction at rest.
    #[serde(default)]
    pub clamp: bool,
    /// Displacement over time: rows of time (s) and displacement along x, y and z (m), linear between the rows and constant outside.
    #[serde(default)]
    pub path: Vec<[f64; 4]>,
}

/// A factor of a material parameter that varies over the body. Give one of `box`, `ball`, `group`, `colour`, `csv`, `texture` and `data`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FieldScene {
    /// Key of the parameter; `pliant plugin info` lists those that may vary.
    #[schemars(with = "String")]
    pub param: Spanned<String>,
    /// Factor within the box, ball or group, 0.1 to 10; 1 elsewhere.
    #[schemars(with = "Option<f64>")]
    pub factor: Option<Spanned<f64>>,
    /// A box, by the corners with the least and the greatest coordinates in the scene.
    #[serde(rename = "box")]
    pub box_: Option<[[Length; 3]; 2]>,
    /// Centre of a ball in the scene.
    pub ball: Option<[Length; 3]>,
    /// Radius of the ball.
    pub radius: Option<Length>,
    /// A name of `g` or `o` lines of the OBJ file: material nearest to its faces. For a tetrahedral mesh a physical group: material nearest to its faces, or its
    /// tetrahedra.
    #[schemars(with = "Option<String>")]
    pub group: Option<Spanned<String>>,
    /// A channel of the vertex colours (`v x y z r g b`), 0 to 1; material has the value of the nearest point of the surface.
    pub colour: Option<Channel>,
    /// Factors at 0 and 1 of the channel or the texture, interpolated geometrically; 0.1 and 10 by default.
    pub range: Option<[f64; 2]>,
    /// Path, relative to the scene, of a file with a line for each vertex, which is its factor. Material has the factor of the nearest point of the surface.
    #[schemars(with = "Option<String>")]
    pub csv: Option<Spanned<String>>,
    /// A grey PNG image, relative to the scene, by the texture coordinates (`vt`) at the nearest place of the surface.
    #[schemars(with = "Option<String>")]
    pub texture: Option<Spanned<String>>,
    /// Name of an array in the file of a tetrahedral mesh, at its nodes (linear between them) or at its elements. Its values are factors, or with `unit` values
    /// of the parameter; allowed is 0.1 to 10 times the value of the material.
    #[schemars(with = "Option<String>")]
    pub data: Option<Spanned<String>>,
    /// Unit of the values of `data`, as `kPa`.
    #[schemars(with = "Option<String>")]
    pub unit: Option<Spanned<String>>,
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
    /// The second of the three numbers after the coordinates of a vertex.
    Green,
    /// The third of the three numbers after the coordinates of a vertex.
    Blue,
}
