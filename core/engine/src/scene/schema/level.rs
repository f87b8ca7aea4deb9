//! A level in a scene: of a grid, or of subdivision.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, Visitor};
use std::borrow::Cow;
use std::fmt;

/// The number of a level, or `auto`: it is chosen when the scene is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The coarsest level whose cells or faces are at most half as wide as the radius of the smallest tool, as far as their number stays within a limit.
    Auto,
    /// The level with this number, from 1.
    At(u32),
}

impl Level {
    /// The level that is given; `None` if it is chosen when the scene is opened.
    pub fn given(self) -> Option<u32> {
        match self {
            Self::Auto => None,
            Self::At(level) => Some(level),
        }
    }
}

impl<'de> Deserialize<'de> for Level {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Read;
        impl Visitor<'_> for Read {
            type Value = Level;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a level: a whole number from 1, or \"auto\"")
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<Level, E> {
                let level = u32::try_from(value).ok().filter(|level| *level > 0);
                level
                    .map(Level::At)
                    .ok_or_else(|| E::custom(format!("level {value}; allowed is a whole number from 1, or \"auto\"")))
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Level, E> {
                match text {
                    "auto" => Ok(Level::Auto),
                    other => Err(E::custom(format!("level {other:?}; allowed is a whole number from 1, or \"auto\""))),
                }
            }
        }
        from.deserialize_any(Read)
    }
}

impl JsonSchema for Level {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Level".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "a level: a whole number from 1, or \"auto\"",
            "anyOf": [{ "type": "integer", "minimum": 1 }, { "const": "auto" }]
        })
    }
}
