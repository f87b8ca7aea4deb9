//! Contact of tools with surfaces: proximity search, proxy, contact forces, and constraints of fingertips on sheets.

mod bodies;
mod fingertip;
mod held;
mod law;
mod law_point;
mod layer;
mod layer_law;
mod loads;
mod near;
mod neighbour_list;
mod obstacles;
mod patch;
mod previous;
mod proxy;
mod sheet_law;
mod sheet_tips;
mod soft;
mod sums;
mod tip_motion;
mod triangle_point;

pub use bodies::{
    BodyCollisions, CollisionReport, CollisionSettings, Compliance, SearchBall, StitchCandidate, StitchSearch,
    TiePoint, TieRow,
};
pub use fingertip::{Press, Tip};
pub use layer::{Layer, Push};
pub use layer_law::{LawStep, LayerLaw};
pub use loads::PointLoads;
pub use near::{ProximitySearch, Query, SKIN_DEPTH, SurfacePoint, depth_on_side, inward, normal_of};
pub use obstacles::{BodyContacts, ObstacleContacts, PlacedObstacle};
pub use patch::Patch;
pub use proxy::{Friction, Proxy, Touch, apply_friction};
pub use sheet_tips::SheetTips;
pub use soft::{SoftMethod, SoftPress, SoftTip};
pub(crate) use sums::NodeSums;
pub use tip_motion::TipResponse;
pub use triangle_point::TrianglePoint;
