//! Progressive cutting of triangle meshes: a blade's edge moves through a mesh, advance by advance, and separates it along its path.
//!
//! This crate is geometry only, in the rest shape: it knows no nodes, elements or forces. [`CutMesh`] is a mesh with its history of cuts, a
//! [`Stroke`] is a cut in progress, and an [`Advance`] reports the changes from which others update elements, nodes and forces. An advance
//! sweeps a strip of one or two triangles (facets), and for each of them
//!
//! 1. `trace` computes the intersection of the facet with the mesh, with exact predicates, without changes;
//! 2. `subdivide` splits the intersected triangles, with a new vertex on each intersected edge;
//! 3. `cap` triangulates the part of the facet that is inside of closed bodies;
//! 4. `stitch` opens the edges along the path and connects two copies of the cap, the walls of the cut, to them;
//! 5. `fans` duplicates vertices whose faces are no longer connected;
//! 6. `verify` checks all changes. A refused advance is tried again with other snapping tolerances; if all fail, the advance is refused and the
//!    mesh is unchanged.
//!
//! A closed body stays closed at every moment: a blade halfway through leaves a slit whose two walls are connected at the blade, and the next
//! advance opens them there. So inside and outside are always defined, and volume is conserved up to rounding.
//!
//! Rejected: a plane through everything (a cut cannot end inside), removal of touched elements (loses volume), cutting first and closing holes
//! afterwards (the hole of an unfinished cut is not planar and has no border on one side), mesh booleans with a thin wedge (closed input only, and
//! the volume of the wedge is lost).
//!
//! # Example
//! One stroke through a ball leaves two closed parts, whose volumes add up to that of the ball:
//! ```
//! use pliant_cut::{Blade, CutMesh, Stroke};
//! use pliant_mesh::{Placement, generate};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut mesh = CutMesh::new(&generate::sphere(12, 0.05)?, &Placement::default());
//! let before = mesh.surface().volume();
//! let blade = |x: f64| Blade { tip: [x, 0.01, -0.1].into(), heel: [x, 0.012, 0.1].into() }; // m
//! let mut stroke = Stroke::begin(blade(-0.08))?;
//! mesh.advance(&mut stroke, blade(0.0))?;
//! assert_eq!(mesh.parts().all.len(), 1, "a slit");
//! mesh.advance(&mut stroke, blade(0.08))?;
//! let parts = mesh.parts().all;
//! assert!(parts.len() == 2 && parts.iter().all(|part| part.closed));
//! let after: f64 = parts.iter().map(|part| part.volume).sum();
//! assert!((after - before).abs() < 1e-12 * before);
//! # Ok(())
//! # }
//! ```

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]
#![deny(clippy::wildcard_enum_match_arm)]

mod advance;
mod blade;
mod cap;
mod cap_point;
pub mod carve;
mod crumb;
mod cut_edges;
mod enclosure;
mod error;
mod fans;
mod flip;
mod front;
mod journal;
mod lids;
mod mesh;
mod normals;
mod part;
mod parts;
mod plane;
mod polygon;
mod record;
mod refine;
mod shape;
mod snap;
mod solid;
mod stitch;
mod strip;
mod subdivide;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
#[cfg(test)]
mod tests;
mod trace;
mod verify;
mod write;

pub use advance::Advance;
pub use blade::{Blade, Stroke};
pub use cap_point::CapPoint;
pub use error::{Refusal, Refused};
pub use mesh::CutMesh;
pub use part::{MeshPart, PartError};
pub use parts::{BodyPart, Part, Parts};
pub use record::Origin;
pub use write::MATERIAL;

use pliant_mesh::geometry::Vec3;
