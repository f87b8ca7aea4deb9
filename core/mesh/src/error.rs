//! Why a mesh cannot be made or used.

use thiserror::Error;

use super::{Finding, ObjError};

/// Why a mesh cannot be made or used.
#[derive(Debug, Error)]
pub enum MeshError {
    /// The surface cannot carry elements of its own. Every finding that forbids it.
    #[error("the mesh cannot carry a material of its own: {}", join(.0))]
    Refused(Vec<Finding>),
    /// A generator or sample was asked for something it cannot make.
    #[error("{parameter} is {found}; allowed: {allowed}")]
    Parameter {
        /// What was asked, by name.
        parameter: &'static str,
        /// What was given.
        found: String,
        /// What can be given.
        allowed: &'static str,
    },
    /// A generator's text is no document: its sizes are too large for its numbers.
    #[error(transparent)]
    Generated(#[from] ObjError),
    /// A surface whose box has no edge cannot be fitted to a size.
    #[error("the longest edge of the box is {found}; allowed: a finite length above 0")]
    NoSize {
        /// Longest edge of the bounding box, file units.
        found: f64,
    },
}

fn join(findings: &[Finding]) -> String {
    findings.iter().map(Finding::to_string).collect::<Vec<_>>().join("; ")
}
