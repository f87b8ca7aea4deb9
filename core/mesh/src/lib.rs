//! Meshes: OBJ documents that keep their bytes, triangle surfaces, tetrahedral meshes, checks and generators, and the geometry over them.
//!
//! This crate knows no physics, no scenes and no cuts. Its main types are:
//!
//! - [`ObjDocument`], an OBJ file with its bytes, so that unedited parts are written back unchanged. A library that merges, splits or
//!   renumbers vertices, such as tobj, cannot do this; tobj is used as a reference in tests and reads material libraries.
//! - [`Surface`], points and triangles with the indices of the file's `v` lines, so that a moved point is written to its own line.
//! - [`EdgeTable`], the edges of triangles with the triangles beside them, and [`check()`], which finds what is wrong with a surface.
//! - [`TetMesh`], a tetrahedral mesh from a Gmsh or VTK file.
//! - [`geometry`]: closest points, rays, and a tree over triangles ([`geometry::TriangleTree`]).
//!
//! The generators ([`generate`], [`sample`]) write OBJ text and parse it, so all models take the same path.
//!
//! # Example
//! A generated ball is closed and has the volume of a polyhedron inside of the sphere; its file comes back byte by byte:
//! ```
//! use pliant_mesh::{Surface, generate};
//! use std::f64::consts::PI;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let radius = 0.05; // m
//! let document = generate::sphere(16, radius)?;
//! let surface = Surface::from_document(&document);
//!
//! assert!(surface.shells().iter().all(|shell| *shell == 0), "one connected component");
//! let euler = surface.points.len() + surface.triangles.len() - surface.edges().len();
//! assert_eq!(euler, 2, "vertices - edges + faces of a closed surface without handles");
//! let ball = 4.0 / 3.0 * PI * radius.powi(3);
//! assert!((0.98 * ball..ball).contains(&surface.volume()));
//!
//! let mut written = Vec::new();
//! document.write(document.positions(), None, &mut written)?;
//! assert_eq!(written, document.bytes());
//! # Ok(())
//! # }
//! ```

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]
#![deny(clippy::wildcard_enum_match_arm)]

pub mod check;
mod disjoint_sets;
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
pub use disjoint_sets::DisjointSets;
pub use edges::{EdgeTable, Side};
pub use error::MeshError;
pub use grey_image::{GreyImage, ImageError, ImageProblem};
pub use obj::{Corner, Face, ObjDocument, ObjError};
pub use placement::Placement;
pub use surface::{Bounds, NO_SHELL, Surface};
pub use tetrahedra::{TetMesh, TetMeshError};
