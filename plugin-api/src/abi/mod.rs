//! The binary interface: plain C structs, the same as in `include/pliant.h`, so that a plugin may be Rust (any rustc), C or C++.
//!
//! Nothing is checked here: plugin authors use the traits of this crate, and the host has its own loader. No Rust enum, `bool`,
//! `String`, `Vec` or ownership of an allocation crosses the interface. Every function pointer that comes from the other side is
//! an `Option`; a null is refused when a plugin is loaded, not inside a loop. `tests/layout.rs` compares both files with one
//! layout. The header states the thread class and the pointer rules of each function.
//!
//! Every struct but [`Param`] and [`Ball`] begins with `size`, its `size_of` as its author compiled it.

mod contact_law;
mod device;
mod directions;
mod grid;
mod material;

pub use contact_law::*;
pub use device::*;
pub use directions::*;
pub use grid::*;
pub use material::*;

use core::ffi::{c_char, c_void};

/// Major version of the interface: host and plugin must have the same.
pub const ABI_MAJOR: u32 = 1;
/// Minor version of the interface: a minor only appends fields, so any minor of the same major loads.
pub const ABI_MINOR: u32 = 1;
/// Name of the one exported symbol, a static [`Library`].
pub const ENTRY_SYMBOL: &[u8] = b"pliant_entry\0";

/// Result of a call: an open set of codes, so a newtype and not a Rust enum.
#[repr(transparent)]
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Status(pub i32);

impl Status {
    /// The call succeeded.
    pub const OK: Self = Self(0);
    /// An argument or parameter is outside what is allowed.
    pub const BAD_ARGUMENT: Self = Self(-1);
    /// The plugin does not offer what was asked.
    pub const UNSUPPORTED: Self = Self(-2);
    /// A result is not finite.
    pub const DIVERGED: Self = Self(-3);
    /// A file or device failed.
    pub const IO: Self = Self(-4);
    /// A panic or exception was caught; the host stops calling the instance.
    pub const PANICKED: Self = Self(-5);
    /// A buffer is too small; the counts beside it say what is needed.
    pub const TOO_SMALL: Self = Self(-6);

    /// The code in words, for a message.
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
            Self(_) => "an unknown status",
        }
    }
}

/// Severity of a message: for information.
pub const INFO: u32 = 0;
/// Severity of a message: works, with a disadvantage.
pub const WARNING: u32 = 1;
/// Severity of a message: does not work.
pub const ERROR: u32 = 2;

/// Kind of parameter: a double within `[min, max]`, in `unit`.
pub const PARAM_NUMBER: u32 = 1;
/// Kind of parameter: one of `choices`, handed over as its index.
pub const PARAM_CHOICE: u32 = 2;
/// Kind of parameter: a UTF-8 text, empty by default.
pub const PARAM_TEXT: u32 = 3;
/// Kind of parameter: path of a file, absolute by the time the plugin sees it; empty by default.
pub const PARAM_PATH: u32 = 4;
/// Kind of parameter: rows x columns of finite doubles, `choices` names the columns; empty by default.
pub const PARAM_TABLE: u32 = 5;

/// Flag of a number of a material: it may differ from element to element, see [`Batch::fields`].
pub const PARAM_FIELD: u32 = 1;

/// Kind of plugin: it offers [`GRID`].
pub const KIND_GRID: u32 = 1;
/// Kind of plugin: it offers [`MATERIAL`].
pub const KIND_MATERIAL: u32 = 2;
/// Kind of plugin: it offers [`DEVICE`].
pub const KIND_DEVICE: u32 = 3;
/// Kind of plugin, since 1.1: it offers [`CONTACT_LAW`].
pub const KIND_CONTACT_LAW: u32 = 4;
/// Flag of a plugin: its `[sim]` and `[servo]` functions do not allocate, lock or do I/O.
pub const FLAG_REAL_TIME: u32 = 1;
/// Flag of a plugin: the same inputs give the same bytes, on the same binary.
pub const FLAG_DETERMINISTIC: u32 = 2;
/// Flag of a material, since 1.1: a call has all elements of its kind, and the host makes one call of an instance at a time. Not with
/// [`CAN_FAIL`]. A host that does not know the flag divides the list between calls of several threads.
pub const FLAG_WHOLE_LISTS: u32 = 4;

/// What the host offers a plugin. It outlives every instance it is handed to.
#[repr(C)]
pub struct Host {
    /// `size_of` this struct.
    pub size: usize,
    /// The host's [`ABI_MAJOR`].
    pub abi_major: u32,
    /// The host's [`ABI_MINOR`].
    pub abi_minor: u32,
    /// The host's own.
    pub data: *mut c_void,
    /// Passes one line of text to the host, which copies its first 255 bytes and never waits.
    pub report: Option<unsafe extern "C" fn(host: *const Host, severity: u32, text: *const c_char)>,
}

/// Declaration of one parameter. It has no `size`: [`Descriptor::param_size`] is the distance between two.
#[repr(C)]
pub struct Param {
    /// [`PARAM_NUMBER`], [`PARAM_CHOICE`], ...
    pub kind: u32,
    /// Key in kebab-case, as in a scene file.
    pub key: *const c_char,
    /// SI unit as text: `"Pa"`, `"kg/m^3"`, `"1"`.
    pub unit: *const c_char,
    /// Description in one line.
    pub summary: *const c_char,
    /// Least value of a number, in `unit`.
    pub min: f64,
    /// Greatest value of a number, in `unit`.
    pub max: f64,
    /// Default of a number, in `unit`, or index of the default choice.
    pub fallback: f64,
    /// Choices or columns, `"one|two|three"`, or null.
    pub choices: *const c_char,
    /// Since 1.1: [`PARAM_FIELD`], or 0.
    pub flags: u32,
}

impl Param {
    /// Size of the struct in interface 1.0, the least there is.
    pub const MIN_SIZE: usize = core::mem::offset_of!(Self, flags);

    /// A copy of the declaration at `from`, of which `size` bytes are there; what its author's version did not have is zero.
    ///
    /// # Safety
    /// `from` points to a parameter of at least [`Param::MIN_SIZE`] and of `size` bytes.
    #[allow(unsafe_code, reason = "reads a struct of another version")]
    pub unsafe fn read(from: *const Self, size: usize) -> Self {
        let mut param = core::mem::MaybeUninit::<Self>::zeroed();
        // SAFETY: `size` bytes are there, at most those of `Self` are taken, and zeros are a valid value of every field.
        unsafe {
            core::ptr::copy_nonoverlapping(from.cast::<u8>(), param.as_mut_ptr().cast(), size.min(size_of::<Self>()));
            param.assume_init()
        }
    }
}

/// What is known of a plugin before an instance exists. It and its strings live as long as the library.
#[repr(C)]
pub struct Descriptor {
    /// `size_of` this struct.
    pub size: usize,
    /// [`KIND_GRID`], [`KIND_MATERIAL`], [`KIND_DEVICE`] or [`KIND_CONTACT_LAW`].
    pub kind: u32,
    /// Bits [`FLAG_REAL_TIME`], [`FLAG_DETERMINISTIC`] and [`FLAG_WHOLE_LISTS`].
    pub flags: u32,
    /// Id in kebab-case, with a reversed domain before it once others use it: `"org.lab.springy"`.
    pub id: *const c_char,
    /// Name for people.
    pub name: *const c_char,
    /// Version of the plugin.
    pub version: *const c_char,
    /// Description in one line.
    pub summary: *const c_char,
    /// Declared parameters (`param_count`, each `param_size` bytes from the next); null if there are none.
    pub params: *const Param,
    /// Number of declared parameters.
    pub param_count: usize,
    /// `size_of::<Param>()` as the plugin was compiled: the distance between two parameters, bytes.
    pub param_size: usize,
}

/// Argument of `activate`.
#[repr(C)]
pub struct Limits {
    /// `size_of` this struct.
    pub size: usize,
    /// Deprecated: s, the time step of the scene. The host still fills it for plugins of 1.0. A substep is shorter and differs
    /// from call to call, so a material reads [`Batch::dt`] and a device the `time_ns` of its calls.
    pub dt: f64,
}

/// One instance of a plugin.
#[repr(C)]
pub struct Plugin {
    /// `size_of` this struct.
    pub size: usize,
    /// The descriptor it was made from.
    pub descriptor: *const Descriptor,
    /// The plugin's own.
    pub data: *mut c_void,
    /// Frees the instance.
    pub destroy: Option<unsafe extern "C" fn(*const Plugin)>,
    /// Sets a number, or a choice by its index.
    pub set_number: Option<unsafe extern "C" fn(*const Plugin, index: u32, value: f64) -> Status>,
    /// Sets a text or a path.
    pub set_text: Option<unsafe extern "C" fn(*const Plugin, index: u32, text: *const c_char) -> Status>,
    /// Sets a table, (rows x columns) row-major.
    pub set_table: Option<
        unsafe extern "C" fn(*const Plugin, index: u32, values: *const f64, rows: usize, columns: usize) -> Status,
    >,
    /// Makes the instance ready for its extensions; its last chance to allocate.
    pub activate: Option<unsafe extern "C" fn(*const Plugin, *const Limits) -> Status>,
    /// Ends what `activate` began.
    pub deactivate: Option<unsafe extern "C" fn(*const Plugin)>,
    /// The function table of an extension id, or null where the plugin does not offer it.
    pub extension: Option<unsafe extern "C" fn(*const Plugin, id: *const c_char) -> *const c_void>,
}

/// The exported entry of a plugin library.
#[repr(C)]
pub struct Library {
    /// `size_of` this struct.
    pub size: usize,
    /// The plugin's [`ABI_MAJOR`].
    pub abi_major: u32,
    /// The plugin's [`ABI_MINOR`].
    pub abi_minor: u32,
    /// Called once, before anything else, with the folder the library is in; may be null.
    pub init: Option<unsafe extern "C" fn(host: *const Host, folder: *const c_char) -> Status>,
    /// The descriptor of plugin number `index`; null ends the list.
    pub descriptor: Option<unsafe extern "C" fn(index: u32) -> *const Descriptor>,
    /// Makes an instance of the plugin `id`; null where it refuses.
    pub create: Option<unsafe extern "C" fn(host: *const Host, id: *const c_char) -> *const Plugin>,
}

/// Makes a struct with raw pointers usable as a static: the pointers must point to other statics, and nothing may write through
/// them.
#[repr(transparent)]
pub struct Shared<T>(pub T);

#[allow(unsafe_code, reason = "a static with raw pointers needs a promise")]
// SAFETY: every value wrapped is immutable and points at immutable statics for the life of the library.
unsafe impl<T> Sync for Shared<T> {}
