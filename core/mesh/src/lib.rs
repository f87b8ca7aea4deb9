//! Surface meshes: OBJ documents, triangle surfaces, and checks of both.
//!
//! [`ObjDocument`] is the file with its bytes, so that unedited parts are written back unchanged. [`Surface`] is the geometry: points and triangles with the indices
//! of the `v` lines, so that a moved point is written to its own line. A library that merges, splits or renumbers vertices, such as tobj, cannot do this; tobj is
//! used as a reference in tests and reads material libraries.
//!
//! Generators and samples produce OBJ text and parse it, so all models take the same path.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]
#![deny(clippy::wildcard_enum_match_arm)]

pub mod check;
pub mod edges;
mod error;
pub mod generate;
pub mod geometry;
pub mod grey_image;
pub mod materials;
pub mod obj;
pub mod placement;
pub mod read;
pub mod sample;
pub mod surface;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
pub mod tetrahedra;
mod triangulate;

pub use check::{Finding, check, require_for_mesh_elements};
pub use edges::{EdgeTable, Side};
pub use error::MeshError;
pub use grey_image::{GreyImage, ImageError, ImageProblem};
pub use obj::{Corner, Face, ObjDocument, ObjError};
pub use placement::Placement;
pub use surface::{Bounds, NO_SHELL, Surface};
pub use tetrahedra::{TetMesh, TetMeshError};
