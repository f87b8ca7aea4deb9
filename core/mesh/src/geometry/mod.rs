//! Points, triangles and rays.

mod closest;
mod cube;
mod groups;
mod ray;
mod tree;
mod vector;

pub use closest::{Closest, closest_point};
pub use cube::meets_cube;
pub use ray::{RayHit, cast, meet};
pub use tree::TriangleTree;
pub use vector::{Vec3, place_bits};
