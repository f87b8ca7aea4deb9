//! `pliant.device/1`.

use super::{Plugin, Status};
use core::ffi::{CStr, c_char, c_void};

/// Extension id of a device.
pub const DEVICE: &CStr = c"pliant.device/1";

/// Extension id of what a device really renders; optional.
pub const RENDERED: &CStr = c"pliant.rendered/1";

/// Extension id of what a device has counted; optional.
pub const COUNTERS: &CStr = c"pliant.counters/1";

/// Extension id of looking for what a device needs; optional.
pub const PROBE: &CStr = c"pliant.probe/1";

pub const POSE_VALID: u32 = 1;
pub const POSE_VELOCITY: u32 = 2;

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceInfo {
    pub size: usize,
    pub effectors: u32,
    pub buttons: u32,
    pub driven_axes: u32,
    pub taxel_rows: u32,
    pub taxel_columns: u32,
    pub rate: f64,
    pub peak_force: f64,
    pub continuous_force: f64,
    pub stiffness: f64,
    pub damping: f64,
    pub resolution: f64,
    pub workspace: [f64; 6],
    pub taxel_pitch: f64,
    pub taxel_force: f64,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    pub size: usize,
    pub time_ns: u64,
    pub flags: u32,
    pub buttons: u32,
    pub position: [f64; 3],
    pub orientation: [f64; 4],
    pub velocity: [f64; 3],
}

impl Default for Pose {
    fn default() -> Self {
        Self {
            size: size_of::<Self>(),
            time_ns: 0,
            flags: 0,
            buttons: 0,
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            velocity: [0.0; 3],
        }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Output {
    pub size: usize,
    pub force: [f64; 3],
    pub torque: [f64; 3],
    pub taxels: *const f64,
    pub valid_until_ns: u64,
}

#[repr(C)]
pub struct Device {
    pub size: usize,
    pub describe: Option<unsafe extern "C" fn(*const Plugin, *mut DeviceInfo) -> Status>,
    pub read: Option<unsafe extern "C" fn(*const Plugin, time_ns: u64, poses: *mut Pose, count: usize) -> Status>,
    pub write:
        Option<unsafe extern "C" fn(*const Plugin, time_ns: u64, outputs: *const Output, count: usize) -> Status>,
    pub stop: Option<unsafe extern "C" fn(*const Plugin) -> Status>,
}

#[repr(C)]
pub struct Rendered {
    pub size: usize,
    pub rendered:
        Option<unsafe extern "C" fn(*const Plugin, time_ns: u64, outputs: *mut Output, count: usize) -> Status>,
}

#[repr(C)]
pub struct Counters {
    pub size: usize,
    pub counter:
        Option<unsafe extern "C" fn(*const Plugin, index: u32, name: *mut *const c_char, value: *mut u64) -> Status>,
}

/// Takes one finding of a probe.
pub type Say = unsafe extern "C" fn(
    data: *mut c_void,
    severity: u32,
    what: *const c_char,
    found: *const c_char,
    remedy: *const c_char,
);

#[repr(C)]
pub struct Probe {
    pub size: usize,
    pub probe: Option<unsafe extern "C" fn(*const Plugin, data: *mut c_void, say: Say) -> Status>,
}
