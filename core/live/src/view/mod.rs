//! What a session looks like, for viewers that must not hold it up.

mod buffer;
mod frame;
mod viewer;

pub use buffer::{ViewReader, ViewWriter, view_buffer};
pub use frame::{BodyTopology, BodyView, TopologyPatch, ViewFrame};
pub use viewer::{Viewer, ViewerThread};
