//! Sources of the values behind a material's choices, such as the measurement of a fabric, as the material declares them.

use crate::error::HostError;
use crate::instance::{Extension, Instance};
use crate::library::Library;
use crate::plugin_info::PluginKind;
use pliant_plugin_api::abi;
use std::ffi::CStr;

/// Source of the values behind one choice of a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChoiceSource {
    /// Index of the parameter in [`PluginInfo::params`](crate::PluginInfo::params).
    pub param: usize,
    /// Index of the choice in the parameter's list.
    pub choice: usize,
    /// The source: author, year, what was measured.
    pub source: String,
    /// Values that the source does not give; empty if it gives all.
    pub unknown: String,
}

/// Largest number of sources that are read from one material.
const MAX_SOURCES: u32 = 1000;

/// The sources that the material `name` of a library declares, in its order; empty if it declares none.
///
/// # Errors
/// Fails for a library without that material and for a malformed table.
#[allow(unsafe_code, reason = "calls the material's list of sources")]
pub fn choice_sources(library: &'static Library, name: &str) -> Result<Vec<ChoiceSource>, HostError> {
    let info = library.plugin(PluginKind::Material, name)?;
    let instance = Instance::create(library, info, &Vec::new(), Extension::new::<abi::Material>(abi::MATERIAL))?;
    let Some(table) = instance.extension_table(Extension::new::<abi::Sources>(abi::SOURCES)) else {
        return Ok(Vec::new());
    };
    // SAFETY: the table of that extension, of at least its size.
    let table: &abi::Sources = unsafe { &*table.cast() };
    let Some(ask) = table.source else { return Ok(Vec::new()) };
    let mut sources = Vec::new();
    for index in 0..MAX_SOURCES {
        let (mut param, mut choice, mut source, mut unknown) = (0, 0, std::ptr::null(), std::ptr::null());
        // SAFETY: [main & !active]; all four are ours to fill.
        let status = unsafe { ask(instance.plugin(), index, &mut param, &mut choice, &mut source, &mut unknown) };
        if status != abi::Status::OK || source.is_null() || unknown.is_null() {
            break;
        }
        // SAFETY: C strings that live as long as the library.
        let [source, unknown] = [source, unknown].map(|t| unsafe { CStr::from_ptr(t) }.to_string_lossy().into_owned());
        sources.push(ChoiceSource { param: param as usize, choice: choice as usize, source, unknown });
    }
    Ok(sources)
}
