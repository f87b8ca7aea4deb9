//! The state of the driver: its open devices, its error stack, and what a test made it do.
#![allow(unsafe_code, reason = "asks the C library for the locale")]

use crate::arm::{Arm, Hand, PEAK_FORCE};
use crate::constants::{INVALID_HANDLE, calibration, capability, error};
use crate::scheduler;
use nalgebra::Vector3;
use std::collections::BTreeSet;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Names of the devices that can be opened.
pub(crate) const DEVICE_NAMES: [&str; 3] = ["Default Device", "left", "right"];

/// The callback of the servo loop and its data, as an address so that it can be sent to the scheduler's thread.
#[derive(Clone, Copy)]
pub(crate) struct Callback {
    pub function: unsafe extern "C" fn(*mut c_void) -> u32,
    pub data: usize,
}

/// An entry of the error stack.
#[derive(Clone, Copy)]
pub(crate) struct StackedError {
    pub code: u32,
    pub handle: u32,
}

/// An open device.
pub(crate) struct Device {
    pub name: String,
    pub arm: Arm,
    /// Capabilities that the host has enabled.
    pub enabled: BTreeSet<u32>,
    pub is_in_frame: bool,
    /// Force set in this frame, N.
    pub frame_force: Vector3<f64>,
    /// Force the motors apply until the next frame ends, N.
    pub applied_force: Vector3<f64>,
    pub buttons: c_int,
    pub in_inkwell: bool,
    pub calibration: u32,
    /// Time in the hand's default motion, s; none once a test moves the hand.
    pub default_motion_time: Option<f64>,
}

impl Device {
    pub(crate) fn new(name: String, calibration: u32) -> Self {
        Self {
            name,
            arm: Arm::new(default_hand_position(0.0)),
            enabled: BTreeSet::new(),
            is_in_frame: false,
            frame_force: Vector3::zeros(),
            applied_force: Vector3::zeros(),
            buttons: 0,
            in_inkwell: false,
            calibration,
            default_motion_time: Some(0.0),
        }
    }

    /// Advances the arm by `dt` (s) under the applied force.
    pub(crate) fn advance(&mut self, dt: f64) {
        if let Some(time) = &mut self.default_motion_time {
            *time += dt;
            self.arm.hand = Hand { target: default_hand_position(*time), stiffness: 300.0, damping: 3.0 };
        }
        self.arm.advance(dt, self.applied_force);
    }

    /// Ends a frame. Returns whether its force was above the limit of the motors while the driver does not clamp it.
    pub(crate) fn end_frame(&mut self, is_unplugged: bool) -> bool {
        let is_on = self.enabled.contains(&capability::FORCE_OUTPUT) && !is_unplugged;
        self.applied_force = if is_on { self.frame_force } else { Vector3::zeros() };
        self.frame_force.norm() > PEAK_FORCE && !self.enabled.contains(&capability::MAX_FORCE_CLAMPING)
    }
}

/// Position of the hand in its default motion, m: it comes down and goes up again along z with a period of 2 s, so that a scene is
/// touched without a test moving the hand.
fn default_hand_position(time: f64) -> Vector3<f64> {
    Vector3::new(0.0, 0.0, 0.006 + 0.009 * (std::f64::consts::PI * time).cos())
}

/// The state of the driver.
pub(crate) struct DriverState {
    /// The devices by handle; none for a handle that was closed.
    pub devices: Vec<Option<Device>>,
    /// Handle of the current device.
    pub current: u32,
    pub errors: Vec<StackedError>,
    /// Error codes that the next frames end with, the last one first.
    pub injected_codes: Vec<u32>,
    /// Error code of scheduling a callback; 0 if it succeeds.
    pub schedule_error: u32,
    pub is_unplugged: bool,
    /// Calibration state of devices opened from now on, and the calibration style.
    pub calibration: u32,
    pub calibration_style: c_int,
    /// Rate of the servo loop, Hz.
    pub rate: u32,
    pub callback: Option<Callback>,
    /// The locale of numbers when a device was last opened.
    pub locale: String,
    /// How often devices were opened.
    pub opened: u64,
    /// How often devices were closed.
    pub closed: u64,
    /// How often a force output that was on was switched off.
    pub outputs_off: u64,
}

impl Default for DriverState {
    fn default() -> Self {
        Self {
            devices: Vec::new(),
            current: INVALID_HANDLE,
            errors: Vec::new(),
            injected_codes: Vec::new(),
            schedule_error: 0,
            is_unplugged: false,
            calibration: calibration::OK,
            calibration_style: calibration::STYLE_AUTO,
            rate: 1000,
            callback: None,
            locale: String::new(),
            opened: 0,
            closed: 0,
            outputs_off: 0,
        }
    }
}

static STATE: Mutex<Option<DriverState>> = Mutex::new(None);
/// Calls that violated the rules of the driver.
static VIOLATIONS: AtomicU64 = AtomicU64::new(0);

/// The locked state of the driver.
pub(crate) struct StateGuard(MutexGuard<'static, Option<DriverState>>);

/// Locks the state of the driver.
pub(crate) fn lock() -> StateGuard {
    let mut state = STATE.lock().unwrap_or_else(PoisonError::into_inner);
    state.get_or_insert_default();
    StateGuard(state)
}

/// Restores the state in which the library is loaded; the scheduler must be stopped.
pub(crate) fn reset() {
    *STATE.lock().unwrap_or_else(PoisonError::into_inner) = None;
    VIOLATIONS.store(0, Ordering::Relaxed);
}

/// Number of calls that violated the rules of the driver.
pub(crate) fn violations() -> u64 {
    VIOLATIONS.load(Ordering::Relaxed)
}

impl Deref for StateGuard {
    type Target = DriverState;
    fn deref(&self) -> &DriverState {
        self.0.as_ref().expect("set by `lock`")
    }
}

impl DerefMut for StateGuard {
    fn deref_mut(&mut self) -> &mut DriverState {
        self.0.as_mut().expect("set by `lock`")
    }
}

impl DriverState {
    /// Pushes an error of the caller; errors of order count as violations.
    pub(crate) fn push_error(&mut self, code: u32) {
        self.errors.push(StackedError { code, handle: self.current });
        if [error::ILLEGAL_BEGIN, error::ILLEGAL_END, error::INVALID_OPERATION].contains(&code) {
            VIOLATIONS.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// The current device, if it is open.
    pub(crate) fn device(&mut self) -> Option<&mut Device> {
        let current = self.current as usize;
        self.devices.get_mut(current).and_then(Option::as_mut)
    }

    /// Opens a device at the first free handle and makes it the current one.
    pub(crate) fn add_device(&mut self, device: Device) -> u32 {
        let index = self.devices.iter().position(Option::is_none).unwrap_or(self.devices.len());
        if index == self.devices.len() {
            self.devices.push(None);
        }
        self.devices[index] = Some(device);
        self.current = index as u32;
        self.current
    }

    /// Enables or disables a capability of the current device; allowed in a callback, and while the scheduler is stopped.
    pub(crate) fn set_capability(&mut self, capability: u32, on: bool) {
        if scheduler::is_running() && !scheduler::is_in_callback() {
            return self.push_error(error::INVALID_OPERATION);
        }
        let Some(device) = self.device() else { return self.push_error(error::BAD_HANDLE) };
        if on {
            device.enabled.insert(capability);
        } else if device.enabled.remove(&capability) && capability == capability::FORCE_OUTPUT {
            self.outputs_off += 1;
        }
    }
}

unsafe extern "C" {
    fn setlocale(category: c_int, locale: *const c_char) -> *const c_char;
}

/// `LC_NUMERIC` of Linux, where the tests run.
const LC_NUMERIC: c_int = 1;

/// The process's locale of numbers.
pub(crate) fn numeric_locale() -> String {
    // SAFETY: a query returns a C string, which is copied at once.
    unsafe {
        let text = setlocale(LC_NUMERIC, std::ptr::null());
        if text.is_null() { String::new() } else { CStr::from_ptr(text).to_string_lossy().into_owned() }
    }
}
