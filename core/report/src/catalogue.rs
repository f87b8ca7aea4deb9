//! Common parts of the catalogues of all reports.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A case that is not run, and why.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct NotRun {
    /// Name of the case.
    pub case: String,
    /// Reason, and what covers the case instead.
    pub why: String,
}

/// Error of parsing a catalogue.
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
        /// Contradiction in the case, as a sentence.
        why: String,
    },
}
