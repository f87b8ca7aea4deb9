//! Points, triangles and rays.

mod closest;
mod cube;
mod tree;
mod vector;

pub use closest::{Closest, closest_point};
pub use cube::meets_cube;
pub use tree::{RayHit, TriangleTree, cast, meet};
pub use vector::Vec3;
