//! Records of the mesh: the origin of a vertex, a triangle with its attributes, and the changes of an advance.

use super::Vec3;

/// Origin of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Origin {
    /// The vertex of the document with the same index.
    Original,
    /// On an edge, at the parameter `t` from its first to its second end.
    Edge {
        /// Vertices of the edge.
        ends: [u32; 2],
        /// Parameter, 0 to 1.
        t: f64,
    },
    /// In a triangle.
    Face {
        /// Vertices of the triangle.
        corners: [u32; 3],
        /// Barycentric coordinates in the triangle: weights of its three corners, sum 1.
        weights: Vec3,
    },
    /// A copy of a vertex on the other side of a cut, at the same rest position.
    Copy {
        /// The copied vertex.
        of: u32,
    },
    /// On the cut surface inside of a body.
    Cap {
        /// Distances along the blade from its tip, and along its path from the beginning of the stroke, m.
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
/// Body index of a triangle that bounds no volume.
pub(super) const OPEN: u32 = u32::MAX;

/// Changes of every advance: of those that can be undone and of those that can be redone.
#[derive(Default)]
pub(super) struct Journal {
    pub done: Vec<Step>,
    pub undone: Vec<Step>,
}

/// Changes of one advance: while it is done, the previous state; while it is undone, the following state.
#[derive(Default)]
pub(super) struct Step {
    pub before: Lengths,
    pub pieces_of: Vec<u32>,         // the old triangle of each new one, or `NONE`
    pub saved: Vec<(u32, Triangle)>, // in the order of change; a triangle may come twice
    pub tail: Tail,                  // empty while done
    pub is_refinement: bool,         // and no advance
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
