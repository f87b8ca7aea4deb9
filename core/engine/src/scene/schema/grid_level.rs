//! The level of a grid, in a scene.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, Visitor};
use std::borrow::Cow;
use std::fmt;

/// The level of a body's grid that is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridLevel {
    /// Cells of at most half the radius of the smallest tool, within a number of cells.
    Auto,
    /// 2^(level - 1) cells along the longest edge of the body.
    At(u32),
}

impl GridLevel {
    /// The level that is given; `None` if it is chosen when the scene is opened.
    pub fn given(self) -> Option<u32> {
        match self {
            Self::Auto => None,
            Self::At(level) => Some(level),
        }
    }
}

impl<'de> Deserialize<'de> for GridLevel {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Read;
        impl Visitor<'_> for Read {
            type Value = GridLevel;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a level: a whole number from 1, or \"auto\"")
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<GridLevel, E> {
                let level = u32::try_from(value).ok().filter(|level| *level > 0);
                level
                    .map(GridLevel::At)
                    .ok_or_else(|| E::custom(format!("level {value}; allowed is a whole number from 1, or \"auto\"")))
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<GridLevel, E> {
                match text {
                    "auto" => Ok(GridLevel::Auto),
                    other => Err(E::custom(format!("level {other:?}; allowed is a whole number from 1, or \"auto\""))),
                }
            }
        }
        from.deserialize_any(Read)
    }
}

impl JsonSchema for GridLevel {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "GridLevel".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "a level: a whole number from 1, or \"auto\"",
            "anyOf": [{ "type": "integer", "minimum": 1 }, { "const": "auto" }]
        })
    }
}
