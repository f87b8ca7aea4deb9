//! Opening, calibrating and closing an arm, outside of the servo loop.
#![allow(unsafe_code, reason = "calls a C library; each call says what makes it sound")]

use crate::arm::Arm;
use crate::driver::DriverClaim;
use crate::errors::{self, ErrorClass};
use crate::hd::{self, Api, Handle, calibration, capability, parameter};
use crate::locale::NumericLocale;
use crate::params::Settings;
use pliant_plugin_api::abi::DeviceInfo;
use std::ffi::{CStr, CString};
use std::ptr::null;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Time between two queries of the calibration.
const CALIBRATION_INTERVAL: Duration = Duration::from_millis(20);

/// Limits for a driver that does not report its own. Continuous force (N) and workspace (m: smallest x y z, largest x y z) are those the
/// vendor publishes for the Omni; stiffness (N/m) and damping (N s/m) are assumptions.
const DEFAULT_CONTINUOUS_FORCE: f64 = 0.88;
const DEFAULT_STIFFNESS: f64 = 500.0;
const DEFAULT_DAMPING: f64 = 2.0;
const DEFAULT_WORKSPACE: [f64; 6] = [-0.08, -0.06, -0.035, 0.08, 0.06, 0.035];
/// Driven axes if the driver does not report them.
const DEFAULT_AXES: u32 = 3;
/// Buttons in the driver's bit mask.
const MAX_BUTTONS: u32 = 4;

/// A message about an error code, with a remedy where there is one.
pub(crate) fn error_message(what: &str, code: u32) -> String {
    let remedy = match errors::class(code) {
        ErrorClass::Licence => "; point OH_SDK_LICENSE_PATH at the driver's licence",
        ErrorClass::Lost => "; look at the cable and the power, and run the vendor's diagnosis",
        ErrorClass::Force | ErrorClass::Usage | ErrorClass::Frame | ErrorClass::Scheduler | ErrorClass::Unknown => "",
    };
    format!("{what}: {} ({code:#06x}){remedy}", errors::name(code))
}

/// An arm that was just opened.
pub(crate) struct OpenedArm {
    pub handle: Handle,
    pub info: DeviceInfo,
}

/// Opens and calibrates an arm, switches its output on and reads its limits. An empty name is the driver's default arm. The scheduler
/// must be stopped.
///
/// # Errors
/// If the driver has no such arm, or it cannot be calibrated, or the driver reports an error; it is closed again then.
pub(crate) fn open_arm(api: &Api, name: &CStr, settings: &Settings) -> Result<OpenedArm, String> {
    let _locale = NumericLocale::set_c();
    api.clear_errors();
    let display_name = name.to_string_lossy();
    // SAFETY: a C string, or null for the default device.
    let handle = unsafe {
        let mut handle = (api.init)(name.as_ptr());
        let mut error = api.clear_errors();
        // Drivers differ in whether the default device is the empty name or null.
        if name.is_empty() && (error.is_some() || handle == hd::INVALID_HANDLE) {
            handle = (api.init)(null());
            error = api.clear_errors();
        }
        if let Some(error) = error {
            return Err(error_message(&format!("arm `{display_name}`"), error.code));
        }
        handle
    };
    if handle == hd::INVALID_HANDLE {
        return Err(format!("arm `{display_name}`: the driver has no such device"));
    }
    let configure = || {
        calibrate(api, &display_name, settings.calibration_timeout)?;
        let info = read_info(api, settings);
        enable_output(api, &display_name)?;
        Ok(info)
    };
    let info = configure().inspect_err(|_: &String| {
        // SAFETY: the handle was returned above.
        unsafe { (api.disable_device)(handle) };
    })?;
    Ok(OpenedArm { handle, info })
}

/// Switches the force output of the current device on; the scheduler is stopped.
fn enable_output(api: &Api, name: &str) -> Result<(), String> {
    // SAFETY: published prototypes.
    unsafe {
        (api.enable)(capability::FORCE_OUTPUT);
        (api.enable)(capability::FORCE_CLAMPING);
        (api.enable)(capability::FORCE_RAMPING);
    }
    // A device without ramping reports a usage error, which is harmless.
    match api.clear_errors() {
        Some(error) if errors::class(error.code) != ErrorClass::Usage => {
            Err(error_message(&format!("arm `{name}`"), error.code))
        }
        Some(_) | None => Ok(()),
    }
}

/// Updates the calibration of the current device. If the user must put the stylus into the inkwell, waits for that until the timeout.
fn calibrate(api: &Api, name: &str, timeout: Duration) -> Result<(), String> {
    let begin = Instant::now();
    loop {
        // SAFETY: published prototypes; the arm is the current device.
        match unsafe { (api.check_calibration)() } {
            calibration::OK => return Ok(()),
            calibration::NEEDS_UPDATE => {
                let style = api.integer(parameter::CALIBRATION_STYLE);
                // SAFETY: as above.
                unsafe { (api.update_calibration)(style as u32) };
            }
            calibration::NEEDS_MANUAL_INPUT
                if api.integer(parameter::CALIBRATION_STYLE) & calibration::STYLE_INKWELL != 0 =>
            {
                if begin.elapsed() > timeout {
                    return Err(format!("arm `{name}` is not calibrated: put the stylus into the inkwell"));
                }
            }
            _ => return Err(format!("arm `{name}` is not calibrated: run the vendor's calibration")),
        }
        if let Some(error) = api.clear_errors() {
            return Err(error_message(&format!("arm `{name}`: calibration"), error.code));
        }
        if begin.elapsed() > timeout {
            return Err(format!("arm `{name}`: the calibration does not end"));
        }
        std::thread::sleep(CALIBRATION_INTERVAL);
    }
}

/// The limits of the current device; those the driver does not report are the parameters or those of an Omni.
fn read_info(api: &Api, settings: &Settings) -> DeviceInfo {
    let positive = |parameter: u32, otherwise: f64| {
        let value = api.doubles(parameter)[0];
        let failed = api.clear_errors().is_some();
        if !failed && value.is_finite() && value > 0.0 { value } else { otherwise }
    };
    let workspace = api.doubles(parameter::USABLE_WORKSPACE);
    let has_workspace = api.clear_errors().is_none() && (0..3).all(|i| workspace[i] < workspace[i + 3]);
    let axes = api.integer(parameter::OUTPUT_DOF);
    api.clear_errors();
    let peak_force = positive(parameter::MAX_FORCE, settings.peak_force).min(settings.peak_force);
    DeviceInfo {
        size: size_of::<DeviceInfo>(),
        effectors: 1,
        buttons: MAX_BUTTONS,
        driven_axes: if axes > 0 { axes as u32 } else { DEFAULT_AXES },
        taxel_rows: 0,
        taxel_columns: 0,
        rate: settings.rate,
        peak_force,
        continuous_force: positive(parameter::MAX_CONTINUOUS_FORCE, DEFAULT_CONTINUOUS_FORCE).min(peak_force),
        // The driver's unit of length is the millimetre.
        stiffness: 1e3 * positive(parameter::MAX_STIFFNESS, 1e-3 * DEFAULT_STIFFNESS),
        damping: 1e3 * positive(parameter::MAX_DAMPING, 1e-3 * DEFAULT_DAMPING),
        resolution: settings.resolution,
        workspace: std::array::from_fn(|i| if has_workspace { 1e-3 * workspace[i] } else { DEFAULT_WORKSPACE[i] }),
        taxel_pitch: 0.0,
        taxel_force: 0.0,
        peak_torque: 0.0,
    }
}

/// Closes the handle of an arm, lost or not: the driver does not open a device twice.
pub(crate) fn close_arm(api: &Api, arm: &Arm) {
    let handle = arm.unclosed_handle.swap(hd::INVALID_HANDLE, Ordering::Relaxed);
    if handle != hd::INVALID_HANDLE {
        // SAFETY: a handle of this driver.
        unsafe { (api.disable_device)(handle) };
        api.clear_errors();
    }
}

/// Opens the first arm, closes it, and returns its model, serial number and largest force as text.
///
/// # Errors
/// If the driver is in use or the arm cannot be opened.
pub(crate) fn probe_arm(settings: &Settings) -> Result<String, String> {
    let _claim = DriverClaim::new()?;
    let api = Api::load(&settings.library)?;
    let name = CString::new(settings.arm.as_str()).unwrap_or_default();
    let OpenedArm { handle, info } = open_arm(&api, &name, settings)?;
    let (model, serial) = (api.text(parameter::MODEL), api.text(parameter::SERIAL));
    // SAFETY: the handle was just returned; the scheduler never ran.
    unsafe {
        (api.disable)(capability::FORCE_OUTPUT);
        (api.disable_device)(handle);
    }
    api.clear_errors();
    Ok(format!("{model} {serial}, {} N", info.peak_force))
}
