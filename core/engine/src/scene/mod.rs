//! Scenes: TOML files in SI units, checked to the key.
//!
//! Parsing gives a [`Scene`] and its [`Source`]; everything that is found wrong later, in a parameter of a plugin or a name
//! that does not exist, is still reported at its line through the source.

mod load;
mod params;
mod schema;
mod set;
mod source;
mod units;

pub use load::{load, load_text};
pub use params::settings;
pub use schema::*;
pub use source::{SceneError, Source};
pub use units::{Quantity, parse_quantity};

/// The JSON Schema of a scene.
pub fn json_schema() -> serde_json::Value {
    schemars::schema_for!(Scene).to_value()
}
