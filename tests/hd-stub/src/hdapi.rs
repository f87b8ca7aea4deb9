//! The exported functions of the driver, with the names and rules of its public documents.
#![allow(unsafe_code, reason = "exports a C interface: pointers are as its documents say, null where they allow it")]

use crate::arm::{OMNI_CONTINUOUS_FORCE, PEAK_FORCE};
use crate::constants::{INVALID_HANDLE, calibration, error, parameter};
use crate::kinematics::{forward, quantized};
use crate::scheduler;
use crate::state::{Callback, DEVICE_NAMES, Device, StackedError, lock, numeric_locale};
use nalgebra::Vector3;
use std::ffi::{CStr, c_char, c_int, c_ulong, c_void};

/// Metres in the driver's unit of length.
const MM_PER_METRE: f64 = 1e3;
/// Rates of the servo loop the driver has, Hz.
const RATES: [c_ulong; 4] = [500, 1000, 1600, 2000];

/// An error record.
#[repr(C)]
pub struct ErrorRecord {
    code: u32,
    internal: c_int,
    handle: u32,
}

// SAFETY of what follows: pointers are what the interface says, large enough for the parameter.

#[unsafe(no_mangle)]
unsafe extern "C" fn hdInitDevice(name: *const c_char) -> u32 {
    let name = if name.is_null() {
        DEVICE_NAMES[0].to_owned()
    } else {
        // SAFETY: a C string.
        unsafe { CStr::from_ptr(name) }.to_string_lossy().into_owned()
    };
    let mut state = lock();
    state.locale = numeric_locale();
    state.current = INVALID_HANDLE;
    let failure = if state.is_unplugged {
        Some(error::COMM_ERROR)
    } else if state.locale != "C" {
        // A decimal comma spoils the configuration.
        Some(error::COMM_CONFIG_ERROR)
    } else if !DEVICE_NAMES.contains(&name.as_str()) {
        Some(error::INVALID_VALUE)
    } else if state.devices.iter().flatten().any(|device| device.name == name) {
        Some(error::DEVICE_ALREADY_INITIATED)
    } else {
        None
    };
    if let Some(code) = failure {
        state.push_error(code);
        return INVALID_HANDLE;
    }
    state.opened += 1;
    let device = Device::new(name, state.calibration);
    state.add_device(device)
}

#[unsafe(no_mangle)]
extern "C" fn hdDisableDevice(handle: u32) {
    let mut state = lock();
    match state.devices.get_mut(handle as usize) {
        Some(device @ Some(_)) => {
            *device = None;
            state.closed += 1;
        }
        Some(None) | None => state.push_error(error::BAD_HANDLE),
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdMakeCurrentDevice(handle: u32) {
    let mut state = lock();
    state.current = handle;
    if state.device().is_none() {
        state.push_error(error::BAD_HANDLE);
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdBeginFrame(handle: u32) {
    let mut state = lock();
    state.current = handle;
    let is_unplugged = state.is_unplugged;
    let Some(device) = state.device() else { return state.push_error(error::BAD_HANDLE) };
    let was_in_frame = std::mem::replace(&mut device.is_in_frame, true);
    device.frame_force = Vector3::zeros();
    if was_in_frame {
        state.push_error(error::ILLEGAL_BEGIN);
    } else if is_unplugged {
        state.push_error(error::COMM_ERROR);
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdEndFrame(handle: u32) {
    let mut state = lock();
    state.current = handle;
    let is_unplugged = state.is_unplugged;
    let Some(device) = state.device() else { return state.push_error(error::BAD_HANDLE) };
    if !std::mem::replace(&mut device.is_in_frame, false) {
        return state.push_error(error::ILLEGAL_END);
    }
    if device.end_frame(is_unplugged) {
        state.push_error(error::EXCEEDED_MAX_FORCE);
    }
    if let Some(code) = state.injected_codes.pop() {
        // Pushed directly: an injected code is not a violation of the caller.
        state.errors.push(StackedError { code, handle });
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdEnable(capability: u32) {
    lock().set_capability(capability, true);
}

#[unsafe(no_mangle)]
extern "C" fn hdDisable(capability: u32) {
    lock().set_capability(capability, false);
}

#[unsafe(no_mangle)]
unsafe extern "C" fn hdGetBooleanv(name: u32, out: *mut u8) {
    let mut state = lock();
    match (name, state.device()) {
        // SAFETY: one value.
        (parameter::CURRENT_INKWELL_SWITCH, Some(device)) => unsafe { *out = u8::from(device.in_inkwell) },
        _ => state.push_error(error::INVALID_ENUM),
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn hdGetIntegerv(name: u32, out: *mut c_int) {
    let mut state = lock();
    let (style, rate) = (state.calibration_style, state.rate as c_int);
    let value = match (name, state.device()) {
        (parameter::CURRENT_BUTTONS, Some(device)) => device.buttons,
        (parameter::OUTPUT_DOF, Some(_)) => 3,
        (parameter::CALIBRATION_STYLE, _) => style,
        (parameter::UPDATE_RATE, _) => rate,
        _ => return state.push_error(error::INVALID_ENUM),
    };
    // SAFETY: one value.
    unsafe { *out = value };
}

#[unsafe(no_mangle)]
unsafe extern "C" fn hdGetDoublev(name: u32, out: *mut f64) {
    let mut state = lock();
    let Some(device) = state.device() else { return state.push_error(error::BAD_HANDLE) };
    let angles = quantized(device.arm.angles());
    let tip = MM_PER_METRE * forward(angles);
    let velocity = MM_PER_METRE * device.arm.velocity();
    let values: Vec<f64> = match name {
        parameter::CURRENT_POSITION => tip.as_slice().to_vec(),
        parameter::CURRENT_VELOCITY => velocity.as_slice().to_vec(),
        parameter::CURRENT_TRANSFORM => {
            // The stylus turns with the waist.
            let (s, c) = angles[0].sin_cos();
            vec![c, 0.0, s, 0.0, 0.0, 1.0, 0.0, 0.0, -s, 0.0, c, 0.0, tip.x, tip.y, tip.z, 1.0]
        }
        parameter::USABLE_WORKSPACE_DIMENSIONS => vec![-80.0, -60.0, -35.0, 80.0, 60.0, 35.0],
        parameter::NOMINAL_MAX_STIFFNESS => vec![0.5],
        parameter::NOMINAL_MAX_FORCE => vec![PEAK_FORCE],
        parameter::NOMINAL_MAX_CONTINUOUS_FORCE => vec![OMNI_CONTINUOUS_FORCE],
        parameter::NOMINAL_MAX_DAMPING => vec![0.002],
        _ => return state.push_error(error::INVALID_ENUM),
    };
    // SAFETY: as many values as the parameter has.
    unsafe { std::slice::from_raw_parts_mut(out, values.len()) }.copy_from_slice(&values);
}

#[unsafe(no_mangle)]
extern "C" fn hdGetString(name: u32) -> *const c_char {
    match name {
        parameter::DEVICE_MODEL_TYPE => c"simulated Omni".as_ptr(),
        parameter::DEVICE_SERIAL_NUMBER => c"without serial number".as_ptr(),
        _ => c"".as_ptr(),
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn hdSetDoublev(name: u32, values: *const f64) {
    let mut state = lock();
    if name != parameter::CURRENT_FORCE {
        return state.push_error(error::INVALID_ENUM);
    }
    // SAFETY: three values.
    let force = Vector3::from_column_slice(unsafe { std::slice::from_raw_parts(values, 3) });
    match state.device() {
        None => state.push_error(error::BAD_HANDLE),
        Some(device) if !device.is_in_frame => state.push_error(error::INVALID_OPERATION),
        Some(device) => device.frame_force = force,
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdGetError() -> ErrorRecord {
    let StackedError { code, handle } = lock().errors.pop().unwrap_or(StackedError { code: 0, handle: INVALID_HANDLE });
    ErrorRecord { code, internal: 0, handle }
}

#[unsafe(no_mangle)]
extern "C" fn hdCheckCalibration() -> u32 {
    lock().device().map_or(calibration::NEEDS_MANUAL_INPUT, |device| device.calibration)
}

#[unsafe(no_mangle)]
extern "C" fn hdUpdateCalibration(_style: u32) {
    let mut state = lock();
    if let Some(device) = state.device().filter(|device| device.calibration == calibration::NEEDS_UPDATE) {
        device.calibration = calibration::OK;
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdSetSchedulerRate(rate: c_ulong) {
    let mut state = lock();
    if RATES.contains(&rate) {
        state.rate = rate as u32;
    } else {
        state.push_error(error::INVALID_VALUE);
    }
}

#[unsafe(no_mangle)]
extern "C" fn hdScheduleAsynchronous(
    function: unsafe extern "C" fn(*mut c_void) -> u32,
    data: *mut c_void,
    _priority: u16,
) -> c_ulong {
    let mut state = lock();
    if state.schedule_error != 0 {
        let code = state.schedule_error;
        state.push_error(code);
        return 0;
    }
    state.callback = Some(Callback { function, data: data as usize });
    1
}

#[unsafe(no_mangle)]
extern "C" fn hdUnschedule(_handle: c_ulong) {
    lock().callback = None;
}

#[unsafe(no_mangle)]
extern "C" fn hdStartScheduler() {
    scheduler::start();
}

#[unsafe(no_mangle)]
extern "C" fn hdStopScheduler() {
    scheduler::stop();
}
