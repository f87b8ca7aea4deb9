//! The `[[stitch]]` entries of a scene file.

use super::{Length, Time};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

/// Points of two bodies that are tied together. The two bodies need no `meets`, and do not collide with each other while they are stitched.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct StitchScene {
    /// Names of the two bodies.
    #[schemars(with = "[String; 2]")]
    pub bodies: [Spanned<String>; 2],
    /// Pairs of a vertex of the first body and one of the second, counted from 0 in the order of the OBJ. Give either this or `distance`.
    #[schemars(with = "Option<Vec<[u32; 2]>>")]
    pub pairs: Option<Spanned<Vec<[u32; 2]>>>,
    /// Distance below which vertices of the finer surface that face the other surface are tied to its nearest points; about one tie for each node.
    #[schemars(with = "Option<Length>")]
    pub distance: Option<Spanned<Length>>,
    /// Time in which points that are apart are drawn together; 0, the default, allows a quarter of an edge between them, which closes in 0.1 s.
    #[schemars(with = "Option<Time>")]
    pub time: Option<Spanned<Time>>,
}
