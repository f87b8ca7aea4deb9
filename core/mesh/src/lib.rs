//! Surface meshes: the OBJ document an artist hands in, the triangles a simulation uses, and what is wrong with either.
//!
//! Two types on purpose. [`ObjDocument`] is the file: bytes first, so that what nobody edited comes back as it was.
//! [`Surface`] is the geometry: points and triangles, numbered like the `v` lines of the file, so that a moved point
//! goes back to its own line. A library that merges, splits or renumbers vertices (tobj) cannot keep that promise;
//! tobj serves here as a second opinion in the tests, and reads the material libraries.
//!
//! Generators and samples make OBJ text and parse it, so there is one way in for every model.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod check;
pub mod edges;
mod error;
pub mod generate;
pub mod geometry;
pub mod materials;
pub mod obj;
pub mod placement;
pub mod read;
pub mod sample;
pub mod surface;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
mod triangulate;

pub use check::{Finding, check, require_for_mesh_elements};
pub use edges::{EdgeTable, Side};
pub use error::MeshError;
pub use obj::{Corner, Face, ObjDocument, ObjError};
pub use placement::Placement;
pub use surface::{Bounds, Surface};
