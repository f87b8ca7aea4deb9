//! Surfaces and tools of a session for viewers, which never delay it.

mod buffer;
mod contact;
mod frame;
mod viewer;

pub use buffer::{ViewReader, ViewWriter, view_buffer};
pub use contact::{BladeEdgeView, ContactPoint};
pub use frame::{BodyTopology, BodyView, TopologyPatch, ViewFrame};
pub use viewer::{Viewer, ViewerThread};
