//! A tool: what a hand holds in the scene, and the force that comes back to it.

mod hand;
mod haptic;
mod knife;
mod meeting;
mod safety;

pub use hand::{Frame, Hand};
pub use haptic::{Coupling, Grip, Mode, Tool, ToolError};
pub use knife::{CutStep, Edge, Inside, Knife};
pub use safety::{Cause, ForceLimits, ForceSafety};
