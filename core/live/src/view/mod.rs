//! Surfaces and tools of a session for viewers, which never delay it.

mod buffer;
mod frame;
mod viewer;

pub use buffer::{ViewReader, ViewWriter, view_buffer};
pub use frame::{BodyTopology, BodyView, TopologyPatch, ViewFrame};
pub use viewer::{Viewer, ViewerThread};
