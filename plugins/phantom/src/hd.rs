//! The part of the HDAPI that is used, as its public headers describe it: types, constants, functions, loaded at run time.
//!
//! Written from the published facts of version 3.0 (unsigned 32-bit handles and enums, C `long` and `unsigned long`, 8-bit
//! booleans, an error record by value, plain C calls but on 32-bit Windows). No file of the vendor is needed to build, and none is here.
#![allow(unsafe_code, reason = "calls a C library; each call says what makes it sound")]

use core::ffi::{CStr, c_char, c_int, c_ulong, c_void};
use std::path::Path;

/// A device.
pub type Handle = u32;
/// What `init` gives when there is no device.
pub const INVALID_HANDLE: Handle = 0xffff_ffff;
/// What a callback gives to be called again.
pub const CONTINUE: u32 = 1;
/// The highest priority of a callback.
pub const MOST_PRIORITY: u16 = u16::MAX;
/// A callback of the scheduler.
pub type Callback = unsafe extern "C" fn(*mut c_void) -> u32;

/// Of the state and the limits.
#[allow(missing_docs, reason = "named as the driver names them")]
pub mod get {
    pub const BUTTONS: u32 = 0x2000;
    pub const INKWELL: u32 = 0x2002;
    pub const VELOCITY: u32 = 0x2051;
    pub const TRANSFORM: u32 = 0x2052;
    pub const MODEL: u32 = 0x2501;
    pub const SERIAL: u32 = 0x2504;
    pub const USABLE_WORKSPACE: u32 = 0x2551;
    pub const OUTPUT_DOF: u32 = 0x2554;
    pub const CALIBRATION_STYLE: u32 = 0x2555;
    pub const UPDATE_RATE: u32 = 0x2600;
    pub const STIFFNESS: u32 = 0x2602;
    pub const FORCE: u32 = 0x2603;
    pub const CONTINUOUS_FORCE: u32 = 0x2604;
    pub const DAMPING: u32 = 0x2609;
    pub const SET_FORCE: u32 = 0x2700;
}

/// What can be switched.
#[allow(missing_docs, reason = "named as the driver names them")]
pub mod switch {
    pub const FORCE_OUTPUT: u32 = 0x4000;
    pub const FORCE_CLAMPING: u32 = 0x4001;
    pub const FORCE_RAMPING: u32 = 0x4002;
}

/// How a device stands with its calibration.
#[allow(missing_docs, reason = "named as the driver names them")]
pub mod calibration {
    pub const OK: u32 = 0x5000;
    pub const NEEDS_UPDATE: u32 = 0x5001;
    pub const NEEDS_MANUAL_INPUT: u32 = 0x5002;
    /// Style: the stylus goes into the inkwell.
    pub const INKWELL: i32 = 4;
}

/// An error record; by value.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ErrorRecord {
    /// 0 is none.
    pub code: u32,
    /// The driver's own.
    pub internal: c_int,
    /// Of the device.
    pub handle: Handle,
}

macro_rules! api {
    ($($name:ident = $symbol:literal: fn($($arg:ty),*) $(-> $out:ty)?;)+) => {
        /// The functions of a driver library, which stays loaded.
        pub struct Api { $(pub(crate) $name: unsafe extern "C" fn($($arg),*) $(-> $out)?,)+ }

        impl Api {
            /// Loads the library, all of it now: nothing is left to be linked inside of a servo loop.
            ///
            /// # Errors
            /// Which file or function is not there.
            pub fn load(file: &Path) -> Result<Self, String> {
                let wrong = |e: libloading::Error| format!("{}: {}", file.display(), because(&e));
                // SAFETY: running a driver's initialisers is what loading it means; the user chose the file or installed it.
                let library = unsafe { open(file) }.map_err(wrong)?;
                // SAFETY: the symbols have the published prototypes.
                let api = unsafe { Self { $($name: *library.get(concat!($symbol, "\0").as_bytes()).map_err(wrong)?,)+ } };
                std::mem::forget(library);
                Ok(api)
            }
        }
    };
}

api! {
    init = "hdInitDevice": fn(*const c_char) -> Handle;
    disable_device = "hdDisableDevice": fn(Handle);
    make_current = "hdMakeCurrentDevice": fn(Handle);
    begin_frame = "hdBeginFrame": fn(Handle);
    end_frame = "hdEndFrame": fn(Handle);
    enable = "hdEnable": fn(u32);
    disable = "hdDisable": fn(u32);
    booleans = "hdGetBooleanv": fn(u32, *mut u8);
    integers = "hdGetIntegerv": fn(u32, *mut c_int);
    doubles = "hdGetDoublev": fn(u32, *mut f64);
    string = "hdGetString": fn(u32) -> *const c_char;
    set_doubles = "hdSetDoublev": fn(u32, *const f64);
    error = "hdGetError": fn() -> ErrorRecord;
    check_calibration = "hdCheckCalibration": fn() -> u32;
    update_calibration = "hdUpdateCalibration": fn(u32);
    start_scheduler = "hdStartScheduler": fn();
    stop_scheduler = "hdStopScheduler": fn();
    set_rate = "hdSetSchedulerRate": fn(c_ulong);
    schedule = "hdScheduleAsynchronous": fn(Callback, *mut c_void, u16) -> c_ulong;
    unschedule = "hdUnschedule": fn(c_ulong);
}

fn because(error: &libloading::Error) -> String {
    std::error::Error::source(error).map_or_else(|| error.to_string(), ToString::to_string)
}

#[cfg(unix)]
unsafe fn open(file: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
    // SAFETY: the caller's promise.
    unsafe { Library::open(Some(file), RTLD_NOW | RTLD_LOCAL) }.map(Into::into)
}

#[cfg(not(unix))]
unsafe fn open(file: &Path) -> Result<libloading::Library, libloading::Error> {
    // SAFETY: the caller's promise.
    unsafe { libloading::Library::new(file) }
}

// SAFETY of the calls below: published prototypes; every buffer is at least as large as the value asked for.
impl Api {
    pub(crate) fn integer(&self, what: u32) -> i32 {
        // Room for the longest value there is, in case a driver gives more than is told.
        let mut values = [0; 16];
        // SAFETY: see above.
        unsafe { (self.integers)(what, values.as_mut_ptr()) };
        values[0]
    }

    pub(crate) fn boolean(&self, what: u32) -> bool {
        let mut values = [0; 16];
        // SAFETY: see above.
        unsafe { (self.booleans)(what, values.as_mut_ptr()) };
        values[0] != 0
    }

    pub(crate) fn numbers(&self, what: u32) -> [f64; 16] {
        let mut values = [0.0; 16];
        // SAFETY: see above.
        unsafe { (self.doubles)(what, values.as_mut_ptr()) };
        values
    }

    pub(crate) fn text(&self, what: u32) -> String {
        // SAFETY: a C string of the driver's own, or null.
        unsafe {
            let text = (self.string)(what);
            if text.is_null() { String::new() } else { CStr::from_ptr(text).to_string_lossy().into_owned() }
        }
    }

    /// Pops the newest error.
    pub(crate) fn pop(&self) -> Option<ErrorRecord> {
        // SAFETY: see above.
        Some(unsafe { (self.error)() }).filter(|e| e.code != 0)
    }

    /// Empties the stack of errors, which a broken driver may fill faster.
    pub(crate) fn clear(&self) -> Option<ErrorRecord> {
        let mut newest = None;
        for _ in 0..64 {
            let Some(error) = self.pop() else { break };
            newest = newest.or(Some(error));
        }
        newest
    }
}
