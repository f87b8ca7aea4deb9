//! Scenes: TOML files in SI units; unknown keys are errors.
//!
//! Parsing gives a [`Scene`] and its [`Source`]. Errors found later, in a parameter of a plugin or an unknown name, are reported with line and
//! column through the source.

mod load;
mod params;
mod schema;
mod set;
mod source;
mod text;
mod units;

pub use load::{load, load_text};
pub use params::settings;
pub use schema::*;
pub use source::{SceneError, Source};
pub use text::SceneText;
pub use units::{Length, Quantity, parse_quantity};

/// The JSON Schema of scene files.
pub fn json_schema() -> serde_json::Value {
    schemars::schema_for!(Scene).to_value()
}
