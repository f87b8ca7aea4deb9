//! Functions for tests, beside those of the vendor: they move the simulated hand, make the driver fail, and read the truth.
#![allow(unsafe_code, reason = "exports a C interface")]

use crate::arm::Hand;
use crate::constants::capability;
use crate::{scheduler, state};
use nalgebra::Vector3;
use std::ffi::c_int;

/// Damping of a hand that a test moves, N s/m.
const HAND_DAMPING: f64 = 3.0;

/// Stops the scheduler and restores the state in which the library is loaded.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_reset() {
    scheduler::stop();
    state::reset();
    scheduler::stall(0);
}

/// Writes how often devices were opened and closed since the reset (2).
///
/// # Safety
/// `counts` has room for two numbers.
#[unsafe(no_mangle)]
unsafe extern "C" fn pliant_stub_read_calls(counts: *mut u64) {
    let state = state::lock();
    // SAFETY: by the promise of the function.
    unsafe { std::ptr::copy_nonoverlapping([state.opened, state.closed].as_ptr(), counts, 2) };
}

/// How often a force output that was on was switched off since the reset.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_outputs_off() -> u64 {
    state::lock().outputs_off
}

/// Lets the next frame end with an error code.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_inject_error(code: u32) {
    state::lock().injected_codes.push(code);
}

/// Lets scheduling a callback fail with an error code; 0 lets it succeed.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_set_schedule_error(code: u32) {
    state::lock().schedule_error = code;
}

/// Plugs the devices in (1) or out (0).
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_set_plugged(plugged: u8) {
    state::lock().is_unplugged = plugged == 0;
}

/// Delays the next tick of the servo loop, ms.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_stall(ms: u64) {
    scheduler::stall(ms);
}

/// Sets the calibration state of devices opened from now on, and the calibration style.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_set_calibration(calibration: u32, style: c_int) {
    let mut state = state::lock();
    state.calibration = calibration;
    state.calibration_style = style;
}

/// Sets the target (m) and the stiffness (N/m) of the hand that holds an arm.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_set_hand(handle: u32, x: f64, y: f64, z: f64, stiffness: f64) {
    if let Some(Some(device)) = state::lock().devices.get_mut(handle as usize) {
        device.default_motion_time = None;
        device.arm.hand = Hand { target: Vector3::new(x, y, z), stiffness, damping: HAND_DAMPING };
    }
}

/// Sets the buttons of an arm, as bits, and whether its stylus is in the inkwell.
#[unsafe(no_mangle)]
extern "C" fn pliant_stub_set_stylus(handle: u32, buttons: c_int, in_inkwell: u8) {
    if let Some(Some(device)) = state::lock().devices.get_mut(handle as usize) {
        (device.buttons, device.in_inkwell) = (buttons, in_inkwell != 0);
    }
}

/// Writes 11 numbers: of an arm the tip (m), the force of the motors (N), the pull of the hand (N) and whether the output is on (1 or 0),
/// all NaN if the arm is not open; then the number of calls that violated the rules of the driver.
#[unsafe(no_mangle)]
unsafe extern "C" fn pliant_stub_read_arm(handle: u32, out: *mut f64) {
    // SAFETY: the caller gives room for 11 numbers.
    let out = unsafe { std::slice::from_raw_parts_mut(out, 11) };
    out.fill(f64::NAN);
    if let Some(Some(device)) = state::lock().devices.get(handle as usize) {
        out[..3].copy_from_slice(device.arm.tip().as_slice());
        out[3..6].copy_from_slice(device.applied_force.as_slice());
        out[6..9].copy_from_slice(device.arm.hand_force().as_slice());
        out[9] = f64::from(u8::from(device.enabled.contains(&capability::FORCE_OUTPUT)));
    }
    out[10] = state::violations() as f64;
}
