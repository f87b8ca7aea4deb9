//! Contact of a tool with a surface: what is near, where the proxy may stand, and what it presses on.

mod fingertip;
mod held;
mod layer;
mod loads;
mod near;
mod on_triangle;
mod patch;
mod proxy;
mod reach;
mod sheet_tips;
mod soft;
mod sums;

pub use fingertip::{Press, Tip};
pub use layer::{Layer, Push};
pub use loads::PlaceLoads;
pub use near::{Near, NearSurface, Query, inward, normal_of};
pub use on_triangle::OnTriangle;
pub use patch::Patch;
pub use proxy::{Friction, Proxy, Touch, hold};
pub use sheet_tips::SheetTips;
pub use soft::{Meets, SoftPress, SoftTip};
