//! The exported symbol of a Rust plugin.

use crate::abi;
use crate::instance::Role;
use core::ffi::{CStr, c_char};
use std::cell::RefCell;

pub use crate::instance::{DescriptorOf, create};

/// A descriptor and the function that makes an instance of it.
pub type Exported = (fn() -> *const abi::Descriptor, fn(*const abi::Host) -> *const abi::Plugin);

/// One row of the list [`crate::export_plugins`] makes.
pub const fn exported<R: Role>() -> Exported {
    (DescriptorOf::<R>::GET, create::<R>)
}

thread_local! {
    /// The text and place of the newest panic on this thread, left here by the hook.
    static PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Replaces the panic hook of this library's own standard library: the default one would print from whichever thread
/// panicked, and the host has a better place for the line.
pub fn install_panic_hook() {
    std::panic::set_hook(Box::new(|info| {
        PANIC.with(|text| {
            if let Ok(mut text) = text.try_borrow_mut() {
                *text = format!("{info}").replace('\n', " ");
            }
        });
    }));
}

/// What the hook left, or `fallback` where it is not installed.
pub(crate) fn last_panic(fallback: &str) -> String {
    let left = PANIC.with(|text| std::mem::take(&mut *text.borrow_mut()));
    if left.is_empty() { format!("panicked: {fallback}") } else { left }
}

/// Finds the plugin `id` in `list` and makes an instance.
///
/// # Safety
/// `host` outlives the instance and `id` is a C string.
#[allow(unsafe_code, reason = "behind the entry")]
pub unsafe fn create_by_id(list: &[Exported], host: *const abi::Host, id: *const c_char) -> *const abi::Plugin {
    let make = || {
        // SAFETY: descriptors hold C strings that live as long as the library; `id` is the caller's promise.
        let found = list.iter().find(|(d, _)| unsafe { CStr::from_ptr((*d()).id) == CStr::from_ptr(id) });
        found.map_or(core::ptr::null(), |(_, create)| create(host))
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

            static PLUGINS: &[$crate::export::Exported] = &[$($crate::export::exported::<$role>()),+];

            /// The entry the host looks for.
            #[allow(unsafe_code, reason = "the exported symbol of a plugin")]
            #[unsafe(no_mangle)]
            #[allow(non_upper_case_globals, reason = "the name is the interface's")]
            pub static pliant_entry: $crate::abi::Shared<$crate::abi::Library> =
                $crate::abi::Shared($crate::abi::Library {
                    size: size_of::<$crate::abi::Library>(),
                    abi_major: $crate::abi::ABI_MAJOR,
                    abi_minor: $crate::abi::ABI_MINOR,
                    init: Some(init),
                    descriptor: Some(descriptor),
                    create: Some(create),
                });

            #[allow(unsafe_code, reason = "behind the entry")]
            unsafe extern "C" fn init(
                _host: *const $crate::abi::Host,
                _folder: *const ::core::ffi::c_char,
            ) -> $crate::abi::Status {
                $crate::export::install_panic_hook();
                $crate::abi::Status::OK
            }

            #[allow(unsafe_code, reason = "behind the entry")]
            unsafe extern "C" fn descriptor(index: u32) -> *const $crate::abi::Descriptor {
                PLUGINS.get(index as usize).map_or(::core::ptr::null(), |(get, _)| get())
            }

            #[allow(unsafe_code, reason = "behind the entry")]
            unsafe extern "C" fn create(
                host: *const $crate::abi::Host,
                id: *const ::core::ffi::c_char,
            ) -> *const $crate::abi::Plugin {
                // SAFETY: passes on what the host promises.
                unsafe { $crate::export::create_by_id(PLUGINS, host, id) }
            }
        }
    };
}
