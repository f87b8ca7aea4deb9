//! The `[[body.stitch]]` entries of a scene file.

use super::Time;
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

/// A seam: vertices of a sheet that become one from the start, or are drawn together first.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SeamScene {
    /// Names of two groups of faces (`g` or `o` lines of the OBJ). The vertices on the border of the sheet whose faces are all of one group are joined, in
    /// their order along the border, with those of the other. Give either this or `pairs`.
    #[schemars(with = "Option<[String; 2]>")]
    pub groups: Option<[Spanned<String>; 2]>,
    /// Pairs of vertices, counted from 0 in the order of the OBJ.
    #[schemars(with = "Option<Vec<[u32; 2]>>")]
    pub pairs: Option<Spanned<Vec<[u32; 2]>>>,
    /// Time in which vertices that are apart are drawn together; 0, the default, allows a quarter of an edge between them.
    #[schemars(with = "Option<Time>")]
    pub time: Option<Spanned<Time>>,
}
