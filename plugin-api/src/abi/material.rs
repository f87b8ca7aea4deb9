//! `pliant.material/1`.

use super::{Plugin, Status};
use core::ffi::{CStr, c_char};

/// Extension id of a material.
pub const MATERIAL: &CStr = c"pliant.material/1";

pub const POINT: u32 = 1;
pub const LINK: u32 = 2;
pub const TRIANGLE: u32 = 3;
pub const HINGE: u32 = 4;
pub const TETRAHEDRON: u32 = 5;

pub const STRUCTURAL: u32 = 1;
pub const SHEAR: u32 = 2;
pub const FLEXION: u32 = 4;
pub const BODY_DIAGONAL: u32 = 8;

pub const HAS_MASS: u32 = 1;
pub const HAS_FORCES: u32 = 2;
pub const HAS_DAMPING: u32 = 4;
pub const HAS_HISTORY: u32 = 8;
pub const IS_COUPLED: u32 = 16;
pub const WANTS_NORMALS: u32 = 32;
pub const HAS_SINGLE: u32 = 64;

/// Set in a slot whose block is stored transposed.
pub const TRANSPOSED: u32 = 0x8000_0000;

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ElementRequest {
    pub size: usize,
    pub kind: u32,
    pub families: u32,
    pub flags: u32,
    pub rest_stride: u32,
    pub history_stride: u32,
}

#[repr(C)]
pub struct Batch {
    pub size: usize,
    pub kind: u32,
    pub corners: u32,
    pub begin: usize,
    pub end: usize,
    pub count: usize,
    pub node_begin: usize,
    pub node_end: usize,
    pub nodes: usize,
    pub elements: *const u32,
    pub family: *const u32,
    pub measure: *const f64,
    pub material: *const f64,
    pub rest: *const f64,
    pub x: *const f64,
    pub v: *const f64,
    pub rest_data: *const f64,
    pub history: *const f64,
    pub time: f64,
    pub dt: f64,
}

#[repr(C)]
pub struct Blocks {
    pub size: usize,
    pub values: *mut f64,
    pub slots: *const u32,
    pub slot_begin: usize,
    pub slot_end: usize,
}

type WriteFn = unsafe extern "C" fn(*const Plugin, *const Batch, *mut f64) -> Status;

#[repr(C)]
pub struct Material {
    pub size: usize,
    pub elements: Option<unsafe extern "C" fn(*const Plugin, index: u32, *mut ElementRequest) -> Status>,
    pub rest: Option<WriteFn>,
    pub mass: Option<WriteFn>,
    pub energy: Option<WriteFn>,
    pub forces: Option<WriteFn>,
    pub tangent: Option<
        unsafe extern "C" fn(*const Plugin, *const Batch, stiffness: f64, damping: f64, *const Blocks) -> Status,
    >,
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
    pub advance: Option<WriteFn>,
}

/// Extension id of coupled hinges; optional.
pub const COUPLED: &CStr = c"pliant.coupled/1";

#[repr(C)]
pub struct Coupled {
    pub size: usize,
    pub strain: Option<unsafe extern "C" fn(*const Plugin, *const Batch, planes: *mut f64) -> Status>,
    pub compliance: Option<unsafe extern "C" fn(*const Plugin, *const Batch, planes: *mut f64) -> Status>,
}

/// Extension id of energies of vertex normals; optional.
pub const NORMALS: &CStr = c"pliant.normals/1";

type NormalsFn = unsafe extern "C" fn(*const Plugin, *const Batch, normals: *const f64, out: *mut f64) -> Status;

#[repr(C)]
pub struct Normals {
    pub size: usize,
    pub energy: Option<NormalsFn>,
    pub forces: Option<NormalsFn>,
    pub tilt: Option<WriteFn>,
}

/// Extension id of stiffness in single precision; optional.
pub const SINGLE: &CStr = c"pliant.single/1";

#[repr(C)]
pub struct SingleBlocks {
    pub size: usize,
    pub values: *mut f32,
    pub slots: *const u32,
    pub slot_begin: usize,
    pub slot_end: usize,
}

#[repr(C)]
pub struct Single {
    pub size: usize,
    pub tangent: Option<
        unsafe extern "C" fn(*const Plugin, *const Batch, stiffness: f64, damping: f64, *const SingleBlocks) -> Status,
    >,
}

/// Extension id of the sources of choices; optional.
pub const SOURCES: &CStr = c"pliant.sources/1";

#[repr(C)]
pub struct Sources {
    pub size: usize,
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
