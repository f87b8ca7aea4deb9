//! What can go wrong with a tool.

use crate::body::LatticeError;

/// What can fail while a tool moves.
pub type ToolError = LatticeError;
