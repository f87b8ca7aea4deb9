//! Queries a device plugin for the requirements of its device, without opening it.

use crate::error::HostError;
use crate::instance::{Extension, Instance, ParamSettings};
use crate::library::Library;
use crate::plugin_info::PluginKind;
use pliant_plugin_api::abi;
use std::ffi::{CStr, c_char, c_void};

pub use pliant_plugin_api::Finding;

/// The requirements of the device `name` of a library, each with its state and a remedy; `None` if the plugin has no probe.
///
/// # Errors
/// Fails for a library without that device, a malformed table, refused parameters and a probe that fails.
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
    // SAFETY: [main & !active]; `add_finding` gets the list passed here, during the call.
    let status =
        instance.within("probe", || unsafe { ask(instance.plugin(), (&raw mut findings).cast(), add_finding) });
    instance.check("probe", status)?;
    Ok(Some(findings))
}

/// Adds a finding of the plugin to `data`, the list of [`probe_device`].
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
    // SAFETY: `data` is what `probe_device` passed, alive for its call; a plugin reports findings one after the other.
    let findings = unsafe { &mut *data.cast::<Vec<Finding>>() };
    findings.push(Finding { severity, what: text(what), found: text(found), remedy: text(remedy) });
}
