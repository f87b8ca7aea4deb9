//! Contact of a tool with a surface: which triangles are near, where the proxy may stand, and what it presses on.

mod closest;
mod layer;
mod loads;
mod near;
mod patch;
mod proxy;

pub use closest::{Closest, closest_point};
pub use layer::Layer;
pub use loads::PlaceLoads;
pub use near::{Near, NearTriangles};
pub use patch::Patch;
pub use proxy::{Friction, Proxy, Touch, hold};
