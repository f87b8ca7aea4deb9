//! Asking a device what it needs, without opening it.

use super::error::HostError;
use super::instance::{Instance, Settings};
use super::library::Library;
use super::plugin::Kind;
use pliant_plugin_api::abi;
use std::ffi::{CStr, c_char, c_void};

pub use pliant_plugin_api::Finding;

/// What the device `name` of a library needs, whether it is there, and how to get it; `None` where it does not say.
///
/// # Errors
/// Whatever the plugin or its tables have wrong.
#[allow(unsafe_code, reason = "calls the device's probe")]
pub fn probe(library: &'static Library, name: &str, settings: &Settings) -> Result<Option<Vec<Finding>>, HostError> {
    let info = library.plugin(Kind::Device, name)?;
    let instance = Instance::make(library, info, settings, abi::DEVICE, size_of::<abi::Device>())?;
    let Some(table) = instance.other_table(abi::PROBE, size_of::<abi::Probe>()) else { return Ok(None) };
    // SAFETY: the table of that extension, of at least its size.
    let table: &abi::Probe = unsafe { &*table.cast() };
    let Some(ask) = table.probe else { return Ok(None) };
    let mut findings: Vec<Finding> = Vec::new();
    // SAFETY: [main & !active]; `take` gets back the list it is handed here, during the call.
    let status = unsafe { ask(instance.plugin(), (&raw mut findings).cast(), take) };
    instance.done("probe", status)?;
    Ok(Some(findings))
}

#[allow(unsafe_code, reason = "called by the plugin with the list of `probe`")]
unsafe extern "C" fn take(
    data: *mut c_void,
    severity: u32,
    what: *const c_char,
    found: *const c_char,
    remedy: *const c_char,
) {
    let text = |from: *const c_char| {
        if from.is_null() {
            return String::new();
        }
        // SAFETY: a C string for the call.
        unsafe { CStr::from_ptr(from) }.to_string_lossy().into_owned()
    };
    // SAFETY: `data` is what `probe` handed over, alive for its call; a plugin says things one after the other.
    let findings = unsafe { &mut *data.cast::<Vec<Finding>>() };
    findings.push(Finding { severity, what: text(what), found: text(found), remedy: text(remedy) });
}
