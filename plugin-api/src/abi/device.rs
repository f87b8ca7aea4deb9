//! `pliant.device/1` and the optional extensions of a device.

use super::{Plugin, Status};
use core::ffi::{CStr, c_char, c_void};

/// Extension id of [`Device`].
pub const DEVICE: &CStr = c"pliant.device/1";

/// Extension id of [`Rendered`]; optional.
pub const RENDERED: &CStr = c"pliant.rendered/1";

/// Extension id of [`Counters`]; optional.
pub const COUNTERS: &CStr = c"pliant.counters/1";

/// Extension id of [`Probe`]; optional.
pub const PROBE: &CStr = c"pliant.probe/1";

/// Flag of a pose: position and orientation were measured for this sample.
pub const POSE_VALID: u32 = 1;
/// Flag of a pose: the velocity was measured too.
pub const POSE_VELOCITY: u32 = 2;

/// The limits of a device.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceInfo {
    /// `size_of` this struct.
    pub size: usize,
    /// End effectors, held or worn: 1 for an arm, 2 for thumb and index.
    pub effectors: u32,
    /// Buttons of each effector.
    pub buttons: u32,
    /// 3 where it renders force, 6 where it renders force and torque.
    pub driven_axes: u32,
    /// Rows of each effector's tactile array, along the effector's y axis; 0: none. The pad faces -z.
    pub taxel_rows: u32,
    /// Columns of each effector's tactile array, along the effector's x axis.
    pub taxel_columns: u32,
    /// Hz, nominal rate of `read` and `write`.
    pub rate: f64,
    /// N, the largest force it renders for a moment.
    pub peak_force: f64,
    /// N, the largest force it renders without end.
    pub continuous_force: f64,
    /// N/m, the largest stiffness it renders stably at `rate`.
    pub stiffness: f64,
    /// N s/m, the largest damping it renders stably at `rate`.
    pub damping: f64,
    /// m, position quantum.
    pub resolution: f64,
    /// m, least and greatest corner; equal where unbounded.
    pub workspace: [f64; 6],
    /// m, distance of two taxels.
    pub taxel_pitch: f64,
    /// N, the largest force of one taxel.
    pub taxel_force: f64,
    /// Since 1.1: N m, the largest torque it renders for a moment; without end the same part of it as the continuous force is of the peak force. 0
    /// where it is not known: torques are then scaled as forces are, and none is rendered live.
    pub peak_torque: f64,
}

impl Default for DeviceInfo {
    /// A device without effectors, limits and workspace, for a plugin to fill.
    fn default() -> Self {
        Self {
            size: size_of::<Self>(),
            effectors: 0,
            buttons: 0,
            driven_axes: 0,
            taxel_rows: 0,
            taxel_columns: 0,
            rate: 0.0,
            peak_force: 0.0,
            continuous_force: 0.0,
            stiffness: 0.0,
            damping: 0.0,
            resolution: 0.0,
            workspace: [0.0; 6],
            taxel_pitch: 0.0,
            taxel_force: 0.0,
            peak_torque: 0.0,
        }
    }
}

/// One sample of an effector.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// `size_of` this struct.
    pub size: usize,
    /// Time of the measurement, ns.
    pub time_ns: u64,
    /// Bits [`POSE_VALID`] and [`POSE_VELOCITY`].
    pub flags: u32,
    /// Pressed buttons; bit i is button i.
    pub buttons: u32,
    /// m, device axes: x right, y up, z towards the user.
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
    /// m/s, device axes.
    pub velocity: [f64; 3],
}

impl Default for Pose {
    /// A pose that was not measured, at the origin.
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

/// What one effector is to render.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// `size_of` this struct.
    pub size: usize,
    /// N, on the hand, device axes.
    pub force: [f64; 3],
    /// N m, on the hand, device axes.
    pub torque: [f64; 3],
    /// (rows x columns) N, or null.
    pub taxels: *const f64,
    /// ns; after this time the device renders zero by itself.
    pub valid_until_ns: u64,
}

/// Function table of [`DEVICE`].
#[repr(C)]
pub struct Device {
    /// `size_of` this struct.
    pub size: usize,
    /// Fills in the device's limits.
    pub describe: Option<unsafe extern "C" fn(*const Plugin, *mut DeviceInfo) -> Status>,
    /// Fills in the poses of all effectors at a time, ns; hardware gives its newest sample instead.
    pub read: Option<unsafe extern "C" fn(*const Plugin, time_ns: u64, poses: *mut Pose, count: usize) -> Status>,
    /// Sets what every effector is to render from a time on, ns.
    pub write:
        Option<unsafe extern "C" fn(*const Plugin, time_ns: u64, outputs: *const Output, count: usize) -> Status>,
    /// Renders zero at once.
    pub stop: Option<unsafe extern "C" fn(*const Plugin) -> Status>,
}

/// Function table of [`RENDERED`]: the force a device really renders.
#[repr(C)]
pub struct Rendered {
    /// `size_of` this struct.
    pub size: usize,
    /// Fills in force and torque of each effector at a time, ns.
    pub rendered:
        Option<unsafe extern "C" fn(*const Plugin, time_ns: u64, outputs: *mut Output, count: usize) -> Status>,
}

/// Function table of [`COUNTERS`]: what a device has counted since it was opened, such as datagrams lost on the way.
#[repr(C)]
pub struct Counters {
    /// `size_of` this struct.
    pub size: usize,
    /// Name and value of counter number `index`; [`Status::UNSUPPORTED`] past the last.
    pub counter:
        Option<unsafe extern "C" fn(*const Plugin, index: u32, name: *mut *const c_char, value: *mut u64) -> Status>,
}

/// Receives one finding of a probe about a requirement `what`: [`super::INFO`] it is met, [`super::WARNING`] the device works worse
/// without it, [`super::ERROR`] the device does not work without it.
pub type Say = unsafe extern "C" fn(
    data: *mut c_void,
    severity: u32,
    what: *const c_char,
    found: *const c_char,
    remedy: *const c_char,
);

/// Function table of [`PROBE`]: checks what a device needs without opening it.
#[repr(C)]
pub struct Probe {
    /// `size_of` this struct.
    pub size: usize,
    /// Passes each finding to `say` together with `data`.
    pub probe: Option<unsafe extern "C" fn(*const Plugin, data: *mut c_void, say: Say) -> Status>,
}
