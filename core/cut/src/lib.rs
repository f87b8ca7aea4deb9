//! Cutting: a blade's edge goes through a mesh, advance by advance, and the mesh comes apart behind it.
//!
//! Geometry only, in the rest shape; what a cut means for elements, nodes and forces is told by [`Advance`] and made
//! elsewhere. An advance sweeps a strip of one or two triangles, and for each of them
//!
//! 1. `trace` decides, once and exactly, where the facet meets the mesh; nothing is changed;
//! 2. `subdivide` splits the triangles it met, a new vertex for each edge crossed;
//! 3. `cap` lays the part of the facet that is inside of closed bodies, as two copies that face each other;
//! 4. `bind` opens the edges along the way and hangs the copies in;
//! 5. `part` gives vertices of their own to what is no longer joined around one;
//! 6. `verify` looks at all that changed. What it refuses is tried once more with more taken as the same place; after that
//!    the advance is refused and the mesh is what it was.
//!
//! A closed body stays closed at every moment: a blade halfway through leaves a slit whose two walls meet where the blade
//! is, and the next advance opens them there. So inside and outside are never in doubt, and volume is kept to rounding.
//!
//! Rejected: a plane through everything (no end inside), removing what the blade touches (loses substance), cutting open and
//! closing holes after (the hole of a half-made cut is not flat and has no rim on one side), mesh booleans with a thin
//! wedge (closed input only, and the wedge's substance is lost).

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod advance;
mod blade;
mod cap;
mod enclosure;
mod error;
mod fans;
mod journal;
mod lids;
mod lines;
mod mesh;
mod normals;
mod parts;
mod plane;
mod polygon;
mod record;
mod snap;
mod solid;
mod stitch;
mod subdivide;
#[cfg(test)]
mod tests;
mod trace;
mod verify;
mod write;

pub use advance::Advance;
pub use blade::{Blade, Stroke};
pub use error::{Refusal, Refused};
pub use mesh::CutMesh;
pub use parts::{Part, Parts};
pub use record::Origin;
pub use write::MATERIAL;

use pliant_mesh::geometry::Vec3;
