//! Hands, tools and the forces on them.

mod hand;
mod model;
mod safety;
mod search;
mod tactile;
mod tip;
#[allow(clippy::module_inception, reason = "the folder is about tools, the file is the tool")]
mod tool;

pub use hand::{Frame, Hand, PreviousPose};
pub use model::{Blend, ContactModel};
pub use safety::{
    Budget, Cause, FADE_TIME, ForceLimits, ForceSafety, HandState, HandTurn, Passivity, STALE_AFTER, TorqueSafety,
};
pub use search::SurfaceSearch;
pub use tactile::{TactilePad, TaxelArray, Texture};
pub use tip::{TipMass, separate};
pub use tool::{Coupling, Tool};
pub(crate) use tool::{diagonal, direction};
