//! A tool: what a hand holds in the scene, and the force that comes back to it.

mod error;
mod hand;
mod haptic;
mod knife;
mod meeting;
mod model;
mod safety;
mod tactile;
mod tip;

pub use error::ToolError;
pub use hand::{Frame, Hand};
pub use haptic::{Coupling, Grip, Mode, Tool};
pub use knife::{CutStep, Edge, Inside, Knife};
pub use model::{Blend, ContactModel};
pub use safety::{Budget, Cause, FADES, ForceLimits, ForceSafety, Moment, PATIENCE, Passivity};
pub use tactile::{TactilePad, TaxelArray, Texture};
pub use tip::{TipMass, part};
