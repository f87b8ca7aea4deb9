//! Asks a device plugin what its device needs, without opening it.

use crate::error::HostError;
use crate::instance::{Extension, Instance, ParamSettings};
use crate::library::Library;
use crate::plugin_info::PluginKind;
use pliant_plugin_api::abi;
use std::ffi::{CStr, c_char, c_void};

pub use pliant_plugin_api::Finding;

/// What the device `name` of a library needs, whether that is there, and how to get it; `None` where the plugin does not say.
///
/// # Errors
/// A library without that device, a malformed table, refused parameters, or a probe that fails.
#[allow(unsafe_code, reason = "calls the device's probe")]
pub fn probe_device(
    library: &'static Library,
    name: &str,
    settings: &ParamSettings,
) -> Result<Option<Vec<Finding>>, HostError> {
    let info = library.plugin(PluginKind::Device, name)?;
    let instance = Instance::create(library, info, settings, Extension::new::<abi::Device>(abi::DEVICE))?;
    let Some(table) = instance.extension_table(Extension::new::<abi::Probe>(abi::PROBE)) else { return Ok(None) };
    // SAFETY: the table of that extension, of at least its size.
    let table: &abi::Probe = unsafe { &*table.cast() };
    let Some(ask) = table.probe else { return Ok(None) };
    let mut findings: Vec<Finding> = Vec::new();
    // SAFETY: [main & !active]; `add_finding` gets back the list it is handed here, during the call.
    let status =
        instance.within("probe", || unsafe { ask(instance.plugin(), (&raw mut findings).cast(), add_finding) });
    instance.check("probe", status)?;
    Ok(Some(findings))
}

/// Called by the plugin for each finding; `data` is the list of [`probe_device`].
#[allow(unsafe_code, reason = "called by the plugin with the list of `probe_device`")]
unsafe extern "C" fn add_finding(
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
    // SAFETY: `data` is what `probe_device` passed, alive for its call; a plugin says things one after the other.
    let findings = unsafe { &mut *data.cast::<Vec<Finding>>() };
    findings.push(Finding { severity, what: text(what), found: text(found), remedy: text(remedy) });
}
