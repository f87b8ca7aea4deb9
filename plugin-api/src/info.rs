//! What is known of a plugin before an instance exists.

use crate::abi;
use crate::param::Param;
use core::ffi::CStr;

/// The descriptor of a plugin, known at compile time.
#[derive(Clone, Copy)]
pub struct Info {
    /// Kebab-case; third parties prefix a reversed domain: `c"org.lab.neo-hookean"`.
    pub id: &'static CStr,
    /// Name for people.
    pub name: &'static CStr,
    /// Version of the plugin, not of the interface.
    pub version: &'static CStr,
    /// One line: the model, and its source (author, year).
    pub summary: &'static CStr,
    /// Every parameter a scene may set, in the order their indices count.
    pub params: &'static [Param],
}

impl Info {
    /// The descriptor of a plugin of a `kind`, [`abi::KIND_MATERIAL`] and so on, with more `flags` than every Rust plugin has.
    pub(crate) const fn descriptor(self, kind: u32, flags: u32) -> abi::Descriptor {
        abi::Descriptor {
            size: size_of::<abi::Descriptor>(),
            kind,
            flags: abi::FLAG_REAL_TIME | abi::FLAG_DETERMINISTIC | flags,
            id: self.id.as_ptr(),
            name: self.name.as_ptr(),
            version: self.version.as_ptr(),
            summary: self.summary.as_ptr(),
            params: self.params.as_ptr().cast(),
            param_count: self.params.len(),
            param_size: size_of::<abi::Param>(),
        }
    }
}
