//! Errors of meshes.

use thiserror::Error;

use super::{Finding, ObjError};

/// Error of generating, placing or using a mesh.
#[derive(Debug, Error)]
pub enum MeshError {
    /// The triangles cannot be elements of a material; with every finding that is an error.
    #[error("the mesh cannot carry a material of its own: {}", join(.0))]
    Refused(Vec<Finding>),
    /// A parameter of a generator or sample is not allowed.
    #[error("{parameter} is {found}; allowed: {allowed}")]
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// The given value.
        found: String,
        /// The allowed values.
        allowed: &'static str,
    },
    /// The generated text cannot be parsed, because its sizes overflow.
    #[error(transparent)]
    Generated(#[from] ObjError),
    /// A surface whose bounding box is a point cannot be scaled to a size.
    #[error("the longest edge of the box is {found}; allowed: a finite length above 0")]
    NoSize {
        /// Longest edge of the bounding box, file units.
        found: f64,
    },
}

fn join(findings: &[Finding]) -> String {
    findings.iter().map(Finding::to_string).collect::<Vec<_>>().join("; ")
}
