//! Whether borders of a model are welded.

use super::Length;
use crate::scene::units::parse_quantity;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, Visitor};
use std::borrow::Cow;
use std::fmt;

/// Whether vertices of borders become one, and how far they may be apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weld {
    /// They stay as the file has them.
    Off,
    /// Those become one that are at most this far apart; 0: those at exactly one place.
    Within(Length),
}

/// What is allowed, for messages.
const ALLOWED: &str = "`true`, `false`, or a length above 0, up to which vertices lie at one place";

impl Weld {
    fn within<E: Error>(metres: f64) -> Result<Self, E> {
        match metres.is_finite() && metres > 0.0 {
            true => Ok(Self::Within(Length::new(metres))),
            false => Err(E::custom(format!("weld = {metres}; allowed is {ALLOWED}"))),
        }
    }
}

impl<'de> Deserialize<'de> for Weld {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Read;
        impl Visitor<'_> for Read {
            type Value = Weld;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(ALLOWED)
            }

            fn visit_bool<E: Error>(self, is_on: bool) -> Result<Weld, E> {
                Ok(if is_on { Weld::Within(Length::new(0.0)) } else { Weld::Off })
            }

            fn visit_f64<E: Error>(self, metres: f64) -> Result<Weld, E> {
                Weld::within(metres)
            }

            fn visit_i64<E: Error>(self, metres: i64) -> Result<Weld, E> {
                Weld::within(metres as f64)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Weld, E> {
                Weld::within(parse_quantity(text, "m").map_err(E::custom)?)
            }
        }
        from.deserialize_any(Read)
    }
}

impl JsonSchema for Weld {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Weld".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "true, false, or a length above 0: a number in m, or a text with a unit",
            "type": ["boolean", "number", "string"]
        })
    }
}
