//! The wire format: plain C structs, the same as in `include/pliant.h`, so that a plugin may be Rust (any rustc), C or C++.
//!
//! Nothing here is checked: a plugin author uses the traits of this crate, the host its own loader. No Rust enum, `bool`,
//! `String`, `Vec` or ownership of an allocation crosses; every function pointer read from the other side is an `Option`,
//! refused when null at load and not in the loop. `tests/layout.rs` holds the two files to one layout. The field docs are
//! in the header, once.
#![allow(missing_docs, reason = "documented in include/pliant.h, which is the reference for both languages")]

mod device;
mod grid;
mod material;

pub use device::*;
pub use grid::*;
pub use material::*;

use core::ffi::{c_char, c_void};

/// Same major loads; a minor only appends.
pub const ABI_MAJOR: u32 = 1;
/// See [`ABI_MAJOR`].
pub const ABI_MINOR: u32 = 0;
/// The one exported symbol, a static [`Library`].
pub const ENTRY_SYMBOL: &[u8] = b"pliant_entry\0";

/// What a call came to: an open set, so a newtype and never a Rust enum.
#[repr(transparent)]
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Status(pub i32);

impl Status {
    pub const OK: Self = Self(0);
    pub const BAD_ARGUMENT: Self = Self(-1);
    pub const UNSUPPORTED: Self = Self(-2);
    pub const DIVERGED: Self = Self(-3);
    pub const IO: Self = Self(-4);
    pub const PANICKED: Self = Self(-5);
    pub const TOO_SMALL: Self = Self(-6);

    /// What the code means, for a message.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::OK => "done",
            Self::BAD_ARGUMENT => "bad argument",
            Self::UNSUPPORTED => "unsupported",
            Self::DIVERGED => "a result is not finite",
            Self::IO => "input or output failed",
            Self::PANICKED => "panicked",
            Self::TOO_SMALL => "a buffer is too small",
            Self(code) if code <= -1000 => "an error of the plugin's own",
            _ => "an unknown status",
        }
    }
}

pub const INFO: u32 = 0;
pub const WARNING: u32 = 1;
pub const ERROR: u32 = 2;

pub const PARAM_NUMBER: u32 = 1;
pub const PARAM_CHOICE: u32 = 2;
pub const PARAM_TEXT: u32 = 3;
pub const PARAM_PATH: u32 = 4;
pub const PARAM_TABLE: u32 = 5;

pub const KIND_GRID: u32 = 1;
pub const KIND_MATERIAL: u32 = 2;
pub const KIND_DEVICE: u32 = 3;
pub const FLAG_REAL_TIME: u32 = 1;
pub const FLAG_DETERMINISTIC: u32 = 2;

#[repr(C)]
pub struct Host {
    pub size: usize,
    pub abi_major: u32,
    pub abi_minor: u32,
    pub data: *mut c_void,
    pub report: Option<unsafe extern "C" fn(host: *const Host, severity: u32, text: *const c_char)>,
}

#[repr(C)]
pub struct Param {
    pub kind: u32,
    pub key: *const c_char,
    pub unit: *const c_char,
    pub summary: *const c_char,
    pub min: f64,
    pub max: f64,
    pub fallback: f64,
    pub choices: *const c_char,
}

#[repr(C)]
pub struct Descriptor {
    pub size: usize,
    pub kind: u32,
    pub flags: u32,
    pub id: *const c_char,
    pub name: *const c_char,
    pub version: *const c_char,
    pub summary: *const c_char,
    pub params: *const Param,
    pub param_count: usize,
    pub param_size: usize,
}

#[repr(C)]
pub struct Limits {
    pub size: usize,
    pub dt: f64,
}

#[repr(C)]
pub struct Plugin {
    pub size: usize,
    pub descriptor: *const Descriptor,
    pub data: *mut c_void,
    pub destroy: Option<unsafe extern "C" fn(*const Plugin)>,
    pub set_number: Option<unsafe extern "C" fn(*const Plugin, index: u32, value: f64) -> Status>,
    pub set_text: Option<unsafe extern "C" fn(*const Plugin, index: u32, text: *const c_char) -> Status>,
    pub set_table: Option<
        unsafe extern "C" fn(*const Plugin, index: u32, values: *const f64, rows: usize, columns: usize) -> Status,
    >,
    pub activate: Option<unsafe extern "C" fn(*const Plugin, *const Limits) -> Status>,
    pub deactivate: Option<unsafe extern "C" fn(*const Plugin)>,
    pub extension: Option<unsafe extern "C" fn(*const Plugin, id: *const c_char) -> *const c_void>,
}

#[repr(C)]
pub struct Library {
    pub size: usize,
    pub abi_major: u32,
    pub abi_minor: u32,
    pub init: Option<unsafe extern "C" fn(host: *const Host, folder: *const c_char) -> Status>,
    pub descriptor: Option<unsafe extern "C" fn(index: u32) -> *const Descriptor>,
    pub create: Option<unsafe extern "C" fn(host: *const Host, id: *const c_char) -> *const Plugin>,
}

/// Statics of these hold pointers to other statics only, and nobody writes through them.
#[repr(transparent)]
pub struct Shared<T>(pub T);

#[allow(unsafe_code, reason = "a static with raw pointers needs a promise")]
// SAFETY: every value wrapped is immutable and points at immutable statics for the life of the library.
unsafe impl<T> Sync for Shared<T> {}
