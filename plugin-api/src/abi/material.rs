//! `pliant.material/1` and the optional extensions of a material.

use super::{Plugin, Status};
use core::ffi::{CStr, c_char};

/// Extension id of [`Material`].
pub const MATERIAL: &CStr = c"pliant.material/1";

/// Element kind with 1 corner; its measure is a share of the volume, m^3, or on a surface of the area, m^2.
pub const POINT: u32 = 1;
/// Element kind with 2 corners; its measure is the boundary weight, 1 inside the body.
pub const LINK: u32 = 2;
/// Element kind with 3 corners; its measure is 1, and each corner has material coordinates, m.
pub const TRIANGLE: u32 = 3;
/// Element kind with 4 corners: the ends a, b of an edge, then the vertex left of it and the one right of it; its measure is 1.
pub const HINGE: u32 = 4;
/// Element kind with 4 corners and positive volume at rest; its measure is the share of it that belongs to the body.
pub const TETRAHEDRON: u32 = 5;

/// Family of links along an edge of a cell.
pub const STRUCTURAL: u32 = 1;
/// Family of links along a face diagonal of a cell.
pub const SHEAR: u32 = 2;
/// Family of links along two edges in a row.
pub const FLEXION: u32 = 4;
/// Family of links along a body diagonal of a cell.
pub const BODY_DIAGONAL: u32 = 8;

/// Flag of a request: the element has mass.
pub const HAS_MASS: u32 = 1;
/// Flag of a request: the element has energy, forces and stiffness.
pub const HAS_FORCES: u32 = 2;
/// Flag of a request: its forces depend on velocity.
pub const HAS_DAMPING: u32 = 4;
/// Flag of a request: `advance` is called after each accepted step.
pub const HAS_HISTORY: u32 = 8;
/// Flag of requests of hinges and triangles: coupled bending, by [`Coupled`].
pub const IS_COUPLED: u32 = 16;
/// Flag of requests of triangles and hinges: an energy of vertex normals, by [`Normals`].
pub const WANTS_NORMALS: u32 = 32;
/// Flag of a request with [`HAS_FORCES`]: stiffness in single precision, by [`Single`].
pub const HAS_SINGLE: u32 = 64;
/// Flag of a tetrahedron request: of the five tetrahedra of a cell only the inner one, which stands for the whole cell. Its measure is
/// three times the share of the cell that belongs to the body. A host that does not know the flag gives all five.
pub const INNER_TETRAHEDRON: u32 = 128;

/// Flag of a request with [`HAS_HISTORY`]: elements may fail, by [`Failure`]. A host that does not know the flag goes on with all of them.
pub const CAN_FAIL: u32 = 256;

/// Set in a slot whose block is stored transposed.
pub const TRANSPOSED: u32 = 0x8000_0000;

/// A kind of element the material works on.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ElementRequest {
    /// `size_of` this struct.
    pub size: usize,
    /// [`POINT`], [`LINK`], ...
    pub kind: u32,
    /// Families of links, or 0.
    pub families: u32,
    /// [`HAS_MASS`], [`HAS_FORCES`], ...
    pub flags: u32,
    /// Doubles of rest data per element.
    pub rest_stride: u32,
    /// Doubles of history per element.
    pub history_stride: u32,
}

/// One call: elements `begin..end` of one kind, all of their nodes in `node_begin..node_end`.
#[repr(C)]
pub struct Batch {
    /// `size_of` this struct.
    pub size: usize,
    /// [`POINT`], [`LINK`], ...
    pub kind: u32,
    /// Corners per element, k.
    pub corners: u32,
    /// First element of the call.
    pub begin: usize,
    /// One past the last element of the call.
    pub end: usize,
    /// Elements of this kind in the body, m.
    pub count: usize,
    /// First node the call may write to.
    pub node_begin: usize,
    /// One past the last node the call may write to.
    pub node_end: usize,
    /// Nodes of the body, n.
    pub nodes: usize,
    /// (m x k) nodes of each element.
    pub elements: *const u32,
    /// (m) family of each link, or null.
    pub family: *const u32,
    /// (m), in the unit of the kind.
    pub measure: *const f64,
    /// (m x k x 2) m, material coordinates of triangles, or null.
    pub material: *const f64,
    /// (n x 3) m, rest positions.
    pub rest: *const f64,
    /// (n x 3) m, positions.
    pub x: *const f64,
    /// (n x 3) m/s, velocities.
    pub v: *const f64,
    /// (rest_stride x m), plane-major: value s of element e at `[s * m + e]`.
    pub rest_data: *const f64,
    /// (history_stride x m), plane-major.
    pub history: *const f64,
    /// s, time of the state.
    pub time: f64,
    /// s, length of the step.
    pub dt: f64,
    /// Since 1.1: planes behind `rest_data`.
    pub rest_stride: usize,
    /// Since 1.1: planes behind `history`.
    pub history_stride: usize,
    /// Since 1.1: planes behind `fields`: as many as the material has parameters with [`super::PARAM_FIELD`], or 0.
    pub field_count: usize,
    /// Since 1.1: (field_count x m), plane-major, or null: factors of these parameters, in the order of their declaration.
    pub fields: *const f64,
}

/// Destination of stiffness: 3 x 3 row-major blocks of the host's symmetric matrix, upper triangle.
#[repr(C)]
pub struct Blocks {
    /// `size_of` this struct.
    pub size: usize,
    /// Block s at `[9 s]`; N/m.
    pub values: *mut f64,
    /// (m x k (k + 1) / 2) block of each pair of corners a <= b, with [`TRANSPOSED`] where it is stored transposed.
    pub slots: *const u32,
    /// First slot this call may write to.
    pub slot_begin: usize,
    /// One past the last slot this call may write to.
    pub slot_end: usize,
}

/// A function that writes or adds doubles for a batch.
type WriteFn = unsafe extern "C" fn(*const Plugin, *const Batch, *mut f64) -> Status;

/// Function table of [`MATERIAL`].
#[repr(C)]
pub struct Material {
    /// `size_of` this struct.
    pub size: usize,
    /// Fills in request number `index`; [`Status::UNSUPPORTED`] ends the list.
    pub elements: Option<unsafe extern "C" fn(*const Plugin, index: u32, *mut ElementRequest) -> Status>,
    /// Writes rest data, plane-major.
    pub rest: Option<WriteFn>,
    /// Adds lumped masses, kg (n).
    pub mass: Option<WriteFn>,
    /// Adds the elastic energy, J.
    pub energy: Option<WriteFn>,
    /// Adds -dE/dx - C v, N (n x 3); v is zero where the host takes C v from the matrix.
    pub forces: Option<WriteFn>,
    /// Adds `stiffness` K + `damping` C.
    pub tangent: Option<
        unsafe extern "C" fn(*const Plugin, *const Batch, stiffness: f64, damping: f64, *const Blocks) -> Status,
    >,
    /// Reserved, null: products with the matrix that is not assembled. No host calls it.
    pub product: Option<
        unsafe extern "C" fn(
            *const Plugin,
            *const Batch,
            stiffness: f64,
            damping: f64,
            p: *const f64,
            out: *mut f64,
        ) -> Status,
    >,
    /// Updates the history after an accepted step, plane-major; may be null where no request has [`HAS_HISTORY`].
    pub advance: Option<WriteFn>,
}

/// Extension id of [`Coupled`]; optional.
pub const COUPLED: &CStr = c"pliant.coupled/1";

/// Function table of [`COUPLED`]: hinges whose bending moments are coupled by the compliance of the triangles between them.
#[repr(C)]
pub struct Coupled {
    /// `size_of` this struct.
    pub size: usize,
    /// For hinges: writes 13 planes, the strain (m) and its gradient by corner and axis.
    pub strain: Option<unsafe extern "C" fn(*const Plugin, *const Batch, planes: *mut f64) -> Status>,
    /// For triangles: writes 6 planes, the compliance (m/N) between the sides 01, 12, 20.
    pub compliance: Option<unsafe extern "C" fn(*const Plugin, *const Batch, planes: *mut f64) -> Status>,
}

/// Extension id of [`Normals`]; optional.
pub const NORMALS: &CStr = c"pliant.normals/1";

/// A function of a batch and the unit normals (n x 3) of all nodes.
type NormalsFn = unsafe extern "C" fn(*const Plugin, *const Batch, normals: *const f64, out: *mut f64) -> Status;

/// Function table of [`NORMALS`]: an energy of triangles that depends on the sheet's unit normals at their corners.
#[repr(C)]
pub struct Normals {
    /// `size_of` this struct.
    pub size: usize,
    /// Adds the energy, J.
    pub energy: Option<NormalsFn>,
    /// Adds -dE/dx at fixed normals, N, and dE/dn, J (n x 6).
    pub forces: Option<NormalsFn>,
    /// Writes 3 planes, N m: the second derivative of the energy by the tilt of a normal across the side 01, 12, 20.
    pub tilt: Option<WriteFn>,
}

/// Extension id of [`Single`]; optional.
pub const SINGLE: &CStr = c"pliant.single/1";

/// As [`Blocks`], in single precision.
#[repr(C)]
pub struct SingleBlocks {
    /// `size_of` this struct.
    pub size: usize,
    /// Block s at `[9 s]`; N/m.
    pub values: *mut f32,
    /// (m x k (k + 1) / 2) block of each pair of corners, diagonal pairs included.
    pub slots: *const u32,
    /// First slot this call may write to.
    pub slot_begin: usize,
    /// One past the last slot this call may write to.
    pub slot_end: usize,
}

/// Function table of [`SINGLE`]: stiffness in single precision.
#[repr(C)]
pub struct Single {
    /// `size_of` this struct.
    pub size: usize,
    /// Adds the off-diagonal blocks of `stiffness` K + `damping` C.
    pub tangent: Option<
        unsafe extern "C" fn(*const Plugin, *const Batch, stiffness: f64, damping: f64, *const SingleBlocks) -> Status,
    >,
}

/// Extension id of [`Failure`]; optional.
pub const FAILURE: &CStr = c"pliant.failure/1";

/// Function table of [`FAILURE`]: elements that have failed.
#[repr(C)]
pub struct Failure {
    /// `size_of` this struct.
    pub size: usize,
    /// Writes 1 for each element that has failed, else 0 (m), from history, rest data, measures and fields alone.
    pub failed: Option<unsafe extern "C" fn(*const Plugin, *const Batch, failed: *mut u8) -> Status>,
}

/// Extension id of [`Sources`]; optional.
pub const SOURCES: &CStr = c"pliant.sources/1";

/// Function table of [`SOURCES`]: the sources of the numbers behind choices.
#[repr(C)]
pub struct Sources {
    /// `size_of` this struct.
    pub size: usize,
    /// Source number `index`: of which choice of which parameter, its citation, and what was not measured;
    /// [`Status::UNSUPPORTED`] past the last.
    pub source: Option<
        unsafe extern "C" fn(
            *const Plugin,
            index: u32,
            param: *mut u32,
            choice: *mut u32,
            source: *mut *const c_char,
            unknown: *mut *const c_char,
        ) -> Status,
    >,
}
