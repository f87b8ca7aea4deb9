//! What the catalogues of all reports have in common.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A case that is not run, and why.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct NotRun {
    /// Name of the case.
    pub case: String,
    /// Why it is not run, and what covers it instead.
    pub why: String,
}

/// Why a text is not a catalogue.
#[derive(Debug, Error)]
pub enum CatalogueError {
    /// The text is not TOML, or has unknown or missing fields.
    #[error("catalogue: {0}")]
    Toml(#[from] toml::de::Error),
    /// A case contradicts itself.
    #[error("catalogue, case `{case}`: {why}")]
    Case {
        /// Name of the case.
        case: String,
        /// What is wrong with it.
        why: String,
    },
}
