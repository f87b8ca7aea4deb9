//! The part of the HDAPI that the plugin uses: types, constants and functions, loaded at run time.
//!
//! Written from the published headers and documents of version 3.0: handles and enumerations have 32 bits without sign, booleans 8 bits,
//! integers are C `int` and `unsigned long`, an error record is returned by value, and all functions have the C calling convention. No
//! file of the vendor is needed to build, and none is in this project.
#![allow(unsafe_code, reason = "calls a C library; each call says what makes it sound")]

use core::ffi::{CStr, c_char, c_int, c_ulong, c_void};
use std::path::Path;

/// Identifies an open device.
pub type Handle = u32;
/// The handle of no device (`HD_INVALID_HANDLE`).
pub const INVALID_HANDLE: Handle = 0xffff_ffff;
/// Result of a callback that is to be called in the next tick too (`HD_CALLBACK_CONTINUE`).
pub const CALLBACK_CONTINUE: u32 = 1;
/// The highest priority of a callback (`HD_MAX_SCHEDULER_PRIORITY`).
pub const MAX_PRIORITY: u16 = u16::MAX;
/// A callback of the scheduler, with the data it was scheduled with.
pub type Callback = unsafe extern "C" fn(*mut c_void) -> u32;

/// Parameters of a device that can be read or set. Lengths are mm, forces N, times s.
pub mod parameter {
    /// Pressed buttons as bits, an integer (`HD_CURRENT_BUTTONS`).
    pub const BUTTONS: u32 = 0x2000;
    /// Whether the stylus is in the inkwell, a boolean (`HD_CURRENT_INKWELL_SWITCH`).
    pub const INKWELL: u32 = 0x2002;
    /// Velocity of the tip, 3 doubles, mm/s (`HD_CURRENT_VELOCITY`).
    pub const VELOCITY: u32 = 0x2051;
    /// Transform of the stylus, 16 doubles, column major, mm (`HD_CURRENT_TRANSFORM`).
    pub const TRANSFORM: u32 = 0x2052;
    /// Name of the model, a string (`HD_DEVICE_MODEL_TYPE`).
    pub const MODEL: u32 = 0x2501;
    /// Serial number, a string (`HD_DEVICE_SERIAL_NUMBER`).
    pub const SERIAL: u32 = 0x2504;
    /// Box in which forces are guaranteed, 6 doubles: smallest x y z, largest x y z, mm (`HD_USABLE_WORKSPACE_DIMENSIONS`).
    pub const USABLE_WORKSPACE: u32 = 0x2551;
    /// Number of driven axes, an integer (`HD_OUTPUT_DOF`).
    pub const OUTPUT_DOF: u32 = 0x2554;
    /// Ways to calibrate, an integer of bits (`HD_CALIBRATION_STYLE`).
    pub const CALIBRATION_STYLE: u32 = 0x2555;
    /// Rate of the servo loop, an integer, Hz (`HD_UPDATE_RATE`).
    pub const UPDATE_RATE: u32 = 0x2600;
    /// Largest recommended stiffness, a double, N/mm (`HD_NOMINAL_MAX_STIFFNESS`).
    pub const MAX_STIFFNESS: u32 = 0x2602;
    /// Largest force when the motors are cold, a double, N (`HD_NOMINAL_MAX_FORCE`).
    pub const MAX_FORCE: u32 = 0x2603;
    /// Largest force that can be held, a double, N (`HD_NOMINAL_MAX_CONTINUOUS_FORCE`).
    pub const MAX_CONTINUOUS_FORCE: u32 = 0x2604;
    /// Largest recommended damping, a double, N s/mm (`HD_NOMINAL_MAX_DAMPING`).
    pub const MAX_DAMPING: u32 = 0x2609;
    /// Force of this frame, 3 doubles, N (`HD_CURRENT_FORCE`).
    pub const FORCE: u32 = 0x2700;
}

/// Capabilities of a device that can be enabled and disabled.
pub mod capability {
    /// Output of forces (`HD_FORCE_OUTPUT`).
    pub const FORCE_OUTPUT: u32 = 0x4000;
    /// The driver limits forces to the largest the device has (`HD_MAX_FORCE_CLAMPING`).
    pub const FORCE_CLAMPING: u32 = 0x4001;
    /// The driver lets the force rise slowly after the output was enabled (`HD_FORCE_RAMPING`).
    pub const FORCE_RAMPING: u32 = 0x4002;
}

/// States and styles of the calibration.
pub mod calibration {
    /// The device is calibrated (`HD_CALIBRATION_OK`).
    pub const OK: u32 = 0x5000;
    /// The calibration must be updated (`HD_CALIBRATION_NEEDS_UPDATE`).
    pub const NEEDS_UPDATE: u32 = 0x5001;
    /// The user must move the device first (`HD_CALIBRATION_NEEDS_MANUAL_INPUT`).
    pub const NEEDS_MANUAL_INPUT: u32 = 0x5002;
    /// Bit of the style: the user puts the stylus into the inkwell (`HD_CALIBRATION_INKWELL`).
    pub const STYLE_INKWELL: i32 = 4;
}

/// An error record, as the driver returns it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ErrorRecord {
    /// Error code; 0 if there is no error.
    pub code: u32,
    /// Code for the vendor's support.
    pub internal: c_int,
    /// The device it concerns.
    pub handle: Handle,
}

macro_rules! api {
    ($($name:ident = $symbol:literal: fn($($arg:ty),*) $(-> $out:ty)?;)+) => {
        /// The functions of a driver library. The library is never unloaded: its threads may still run.
        pub struct Api { $(pub(crate) $name: unsafe extern "C" fn($($arg),*) $(-> $out)?,)+ }

        impl Api {
            /// Loads the library and resolves all its symbols, so that the servo loop never waits for the linker.
            ///
            /// # Errors
            /// If the file or a function is missing; the message names it.
            pub fn load(file: &Path) -> Result<Self, String> {
                let message = |e: libloading::Error| format!("{}: {}", file.display(), cause(&e));
                // SAFETY: running a driver's initialisers is what loading it means; the user chose the file or installed it.
                let library = unsafe { open(file) }.map_err(message)?;
                // SAFETY: the symbols have the published prototypes.
                let api = unsafe { Self { $($name: *library.get(concat!($symbol, "\0").as_bytes()).map_err(message)?,)+ } };
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
    get_booleans = "hdGetBooleanv": fn(u32, *mut u8);
    get_integers = "hdGetIntegerv": fn(u32, *mut c_int);
    get_doubles = "hdGetDoublev": fn(u32, *mut f64);
    get_string = "hdGetString": fn(u32) -> *const c_char;
    set_doubles = "hdSetDoublev": fn(u32, *const f64);
    get_error = "hdGetError": fn() -> ErrorRecord;
    check_calibration = "hdCheckCalibration": fn() -> u32;
    update_calibration = "hdUpdateCalibration": fn(u32);
    start_scheduler = "hdStartScheduler": fn();
    stop_scheduler = "hdStopScheduler": fn();
    set_scheduler_rate = "hdSetSchedulerRate": fn(c_ulong);
    schedule = "hdScheduleAsynchronous": fn(Callback, *mut c_void, u16) -> c_ulong;
    unschedule = "hdUnschedule": fn(c_ulong);
}

/// The system's own message; that of `libloading` only names its function.
fn cause(error: &libloading::Error) -> String {
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

/// Numbers in a buffer for a parameter: more than the longest parameter has, in case a driver writes more than documented.
const BUFFER_NUMBERS: usize = 16;
/// Most errors removed at once: a broken driver may report new ones faster than they are removed.
const MAX_ERRORS_CLEARED: usize = 64;

// SAFETY of the calls below: published prototypes; every buffer is at least as large as the parameter.
impl Api {
    /// An integer parameter of the current device.
    pub(crate) fn integer(&self, parameter: u32) -> i32 {
        let mut values = [0; BUFFER_NUMBERS];
        // SAFETY: see above.
        unsafe { (self.get_integers)(parameter, values.as_mut_ptr()) };
        values[0]
    }

    /// A boolean parameter of the current device.
    pub(crate) fn boolean(&self, parameter: u32) -> bool {
        let mut values = [0; BUFFER_NUMBERS];
        // SAFETY: see above.
        unsafe { (self.get_booleans)(parameter, values.as_mut_ptr()) };
        values[0] != 0
    }

    /// A parameter of doubles of the current device; zeros after its last.
    pub(crate) fn doubles(&self, parameter: u32) -> [f64; BUFFER_NUMBERS] {
        let mut values = [0.0; BUFFER_NUMBERS];
        // SAFETY: see above.
        unsafe { (self.get_doubles)(parameter, values.as_mut_ptr()) };
        values
    }

    /// A string parameter of the current device; empty if it has none.
    pub(crate) fn text(&self, parameter: u32) -> String {
        // SAFETY: a C string of the driver's own, or null.
        unsafe {
            let text = (self.get_string)(parameter);
            if text.is_null() { String::new() } else { CStr::from_ptr(text).to_string_lossy().into_owned() }
        }
    }

    /// Removes the newest error from the driver's stack and returns it.
    pub(crate) fn pop_error(&self) -> Option<ErrorRecord> {
        // SAFETY: see above.
        Some(unsafe { (self.get_error)() }).filter(|e| e.code != 0)
    }

    /// Removes all errors from the driver's stack and returns the newest.
    pub(crate) fn clear_errors(&self) -> Option<ErrorRecord> {
        let mut newest = None;
        for _ in 0..MAX_ERRORS_CLEARED {
            let Some(error) = self.pop_error() else { break };
            newest = newest.or(Some(error));
        }
        newest
    }
}
