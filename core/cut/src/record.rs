//! Records of the mesh: where vertices come from, one triangle with all that belongs to it, and what an advance changed.

use super::Vec3;
use super::blade::Stroke;

/// Where a vertex came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Origin {
    /// It was there before any cut: the vertex of the document with the same number.
    Original,
    /// On an edge, `t` of the way from its first end to its second.
    Edge {
        /// The ends.
        ends: [u32; 2],
        /// 0 to 1.
        t: f64,
    },
    /// In a triangle.
    Face {
        /// Its corners.
        corners: [u32; 3],
        /// Their weights.
        weights: Vec3,
    },
    /// The other side of a vertex that was parted: at the same rest place when it was made.
    Copy {
        /// The vertex.
        of: u32,
    },
    /// On the cut surface, inside a body.
    Cap {
        /// Along the blade from the tip, and along its way since the stroke began, m.
        strip: [f64; 2],
    },
}

/// A triangle: its corners, links and rows of texture coordinates and normals (3 each), face of the document, and body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Triangle {
    pub corners: [u32; 3],
    pub links: [u32; 3],
    pub texture: [u32; 3],
    pub shading: [u32; 3],
    pub face: u32,
    pub body: u32,
}

/// No row, node or triangle.
pub(super) const NONE: u32 = u32::MAX;
/// The body of a triangle that bounds no volume.
pub(super) const OPEN: u32 = u32::MAX;

/// What every advance changed: those that are done, and those undone.
#[derive(Default)]
pub(super) struct Journal {
    pub done: Vec<Step>,
    pub undone: Vec<Step>,
}

/// One advance: while it is done, what was before; while it is undone, what comes after.
#[derive(Default)]
pub(super) struct Step {
    pub before: Lengths,
    pub pieces_of: Vec<u32>,          // of each new triangle the one it was cut from, or `NONE`
    pub saved: Vec<(u32, Triangle)>,  // in the order of change; a triangle may come twice
    pub tail: Tail,                   // empty while done
    pub strokes: Option<[Stroke; 2]>, // before and after
}

#[derive(Clone, Copy, Default)]
pub(super) struct Lengths {
    pub points: usize,
    pub triangles: usize,
    pub texcoords: usize,
    pub normals: usize,
}

#[derive(Default)]
pub(super) struct Tail {
    pub points: Vec<(Vec3, Origin)>,
    pub triangles: Vec<Triangle>,
    pub texcoords: Vec<[f64; 2]>,
    pub normals: Vec<Vec3>,
}
