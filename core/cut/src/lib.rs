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
mod bind;
mod blade;
mod cap;
mod error;
mod journal;
mod lids;
mod lines;
mod mesh;
mod normals;
mod part;
mod parts;
mod plane;
mod polygon;
mod solid;
mod subdivide;
#[cfg(test)]
mod tests;
mod trace;
mod verify;
mod write;

pub use blade::{Blade, Stroke};
pub use error::{Refusal, Refused};
pub use mesh::{CutMesh, Origin};
pub use parts::{Part, Parts};
pub use write::MATERIAL;

use pliant_mesh::geometry::Vec3;

/// What an advance did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Advance {
    /// New cut surface inside of closed bodies, one wall of two, m^2.
    pub area: f64,
    /// New cut edge on the surface, one side of two, m.
    pub length: f64,
    /// Triangles there were before that are split, or have another vertex or neighbour, rising.
    pub changed: Vec<u32>,
    /// New triangles have this number and above.
    pub first_triangle: u32,
    /// The triangle there was before that each new one is a piece of; `u32::MAX` for one of a wall.
    pub pieces_of: Vec<u32>,
    /// New vertices have this number and above.
    pub first_vertex: u32,
    /// Vertices that came apart, each with the new one at the same place.
    pub parted: Vec<[u32; 2]>,
    /// What the blade swept: triangles in the rest shape, none to two.
    pub facets: Vec<[Vec3; 3]>,
}

impl Advance {
    /// Whether the mesh is other than before.
    pub fn has_cut(&self) -> bool {
        !self.changed.is_empty()
    }
}
