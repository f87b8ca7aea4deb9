//! The exported symbol of a Rust plugin library.

use crate::abi;
use crate::instance::Role;
use core::ffi::{CStr, c_char};
use std::cell::RefCell;

pub use crate::instance::{DescriptorOf, create};

/// One plugin of a library, as [`crate::export_plugins`] lists it.
pub struct ExportedPlugin {
    /// Gives a pointer to the plugin's descriptor.
    pub descriptor: fn() -> *const abi::Descriptor,
    /// Makes an instance.
    pub create: fn(*const abi::Host) -> *const abi::Plugin,
}

/// The entry of a role in the list of exported plugins.
pub const fn exported<R: Role>() -> ExportedPlugin {
    ExportedPlugin { descriptor: DescriptorOf::<R>::GET, create: create::<R> }
}

thread_local! {
    /// Message and source location of the last panic on this thread, written by the hook.
    static PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Replaces the panic hook of this library's copy of the standard library. The default hook prints to standard error from the thread
/// that panicked; this one keeps the message for `last_panic`, so that it reaches the host's report.
pub fn install_panic_hook() {
    std::panic::set_hook(Box::new(|info| {
        PANIC.with(|text| {
            if let Ok(mut text) = text.try_borrow_mut() {
                *text = format!("{info}").replace('\n', " ");
            }
        });
    }));
}

/// The message the hook kept, or `fallback` where the hook is not installed.
pub(crate) fn last_panic(fallback: &str) -> String {
    let message = PANIC.with(|text| std::mem::take(&mut *text.borrow_mut()));
    if message.is_empty() { format!("panicked: {fallback}") } else { message }
}

/// Makes an instance of the plugin `id` in `list`; null where the list has no such plugin, or where it panics.
///
/// # Safety
/// `host` outlives the instance and `id` is a C string.
#[allow(unsafe_code, reason = "called by the exported entry")]
pub unsafe fn create_by_id(list: &[ExportedPlugin], host: *const abi::Host, id: *const c_char) -> *const abi::Plugin {
    let make = || {
        // SAFETY: descriptors hold C strings that live as long as the library; `id` is the caller's promise.
        let found = list.iter().find(|p| unsafe { CStr::from_ptr((*(p.descriptor)()).id) == CStr::from_ptr(id) });
        found.map_or(core::ptr::null(), |plugin| (plugin.create)(host))
    };
    std::panic::catch_unwind(make).unwrap_or(core::ptr::null())
}

/// Exports plugins from a `cdylib`: `export_plugins!(AsMaterial<Spring>, AsGrid<Tree>);`
///
/// Refuses to compile with `panic = "abort"`, under which a panic in the plugin would end the host.
#[macro_export]
macro_rules! export_plugins {
    ($($role:ty),+ $(,)?) => {
        #[cfg(panic = "abort")]
        compile_error!("a pliant plugin must be built with panic = \"unwind\"");

        mod pliant_export {
            use super::*;

            static PLUGINS: &[$crate::export::ExportedPlugin] = &[$($crate::export::exported::<$role>()),+];

            /// The entry the host looks up by name.
            #[allow(unsafe_code, reason = "the exported symbol of a plugin")]
            #[unsafe(no_mangle)]
            #[allow(non_upper_case_globals, reason = "the interface prescribes the name")]
            pub static pliant_entry: $crate::abi::Shared<$crate::abi::Library> =
                $crate::abi::Shared($crate::abi::Library {
                    size: size_of::<$crate::abi::Library>(),
                    abi_major: $crate::abi::ABI_MAJOR,
                    abi_minor: $crate::abi::ABI_MINOR,
                    init: Some(init),
                    descriptor: Some(descriptor),
                    create: Some(create),
                });

            #[allow(unsafe_code, reason = "called by the host")]
            unsafe extern "C" fn init(
                _host: *const $crate::abi::Host,
                _folder: *const ::core::ffi::c_char,
            ) -> $crate::abi::Status {
                $crate::export::install_panic_hook();
                $crate::abi::Status::OK
            }

            #[allow(unsafe_code, reason = "called by the host")]
            unsafe extern "C" fn descriptor(index: u32) -> *const $crate::abi::Descriptor {
                PLUGINS.get(index as usize).map_or(::core::ptr::null(), |plugin| (plugin.descriptor)())
            }

            #[allow(unsafe_code, reason = "called by the host")]
            unsafe extern "C" fn create(
                host: *const $crate::abi::Host,
                id: *const ::core::ffi::c_char,
            ) -> *const $crate::abi::Plugin {
                // SAFETY: the host's promises are those of `create_by_id`.
                unsafe { $crate::export::create_by_id(PLUGINS, host, id) }
            }
        }
    };
}
