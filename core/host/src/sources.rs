//! Where the numbers behind a material's choices come from, as it says itself.

use super::error::HostError;
use super::instance::Instance;
use super::library::Library;
use super::plugin::Kind;
use pliant_plugin_api::abi;
use std::ffi::CStr;

/// Where the numbers behind a choice come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChoiceSource {
    /// Place of the parameter.
    pub param: usize,
    /// Place of the choice.
    pub choice: usize,
    /// Who measured what, and when.
    pub source: String,
    /// What it leaves open; empty where nothing.
    pub unknown: String,
}

/// The most that are asked for.
const MOST: u32 = 1000;

/// The sources of the material `name` of a library, in its own order; none where it does not say.
///
/// # Errors
/// Whatever the plugin or its tables have wrong.
#[allow(unsafe_code, reason = "calls the material's list of sources")]
pub fn sources(library: &'static Library, name: &str) -> Result<Vec<ChoiceSource>, HostError> {
    let info = library.plugin(Kind::Material, name)?;
    let instance = Instance::make(library, info, &Vec::new(), abi::MATERIAL, size_of::<abi::Material>())?;
    let Some(table) = instance.other_table(abi::SOURCES, size_of::<abi::Sources>()) else { return Ok(Vec::new()) };
    // SAFETY: the table of that extension, of at least its size.
    let table: &abi::Sources = unsafe { &*table.cast() };
    let Some(ask) = table.source else { return Ok(Vec::new()) };
    let mut found = Vec::new();
    for index in 0..MOST {
        let (mut param, mut choice, mut source, mut unknown) = (0, 0, std::ptr::null(), std::ptr::null());
        // SAFETY: [main & !active]; all four are ours to fill.
        let status = unsafe { ask(instance.plugin(), index, &mut param, &mut choice, &mut source, &mut unknown) };
        if status != abi::Status::OK || source.is_null() || unknown.is_null() {
            break;
        }
        // SAFETY: C strings that live as long as the library.
        let [source, unknown] = [source, unknown].map(|t| unsafe { CStr::from_ptr(t) }.to_string_lossy().into_owned());
        found.push(ChoiceSource { param: param as usize, choice: choice as usize, source, unknown });
    }
    Ok(found)
}
