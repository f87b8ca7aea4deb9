//! Corotational tetrahedra (Etzmuss, Keckeisen and Strasser 2003; Müller and Gross 2004), written in C++.
//!
//! The plugin is in `corotational.cpp`. This file exports the entry, because a library linked by cargo exports Rust symbols only. A plugin
//! that is built with a C++ compiler alone exports `pliant_entry` itself: see the plugin guide.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

use core::ffi::c_char;
use pliant_plugin_api::abi::{ABI_MAJOR, ABI_MINOR, Descriptor, Host, Library, Plugin, Shared, Status};

#[allow(unsafe_code, reason = "functions in C++")]
unsafe extern "C" {
    fn corotational_init(host: *const Host, folder: *const c_char) -> Status;
    fn corotational_descriptor(index: u32) -> *const Descriptor;
    fn corotational_create(host: *const Host, id: *const c_char) -> *const Plugin;
}

/// The entry the host looks up by name.
#[allow(unsafe_code, reason = "the exported symbol of a plugin")]
#[unsafe(no_mangle)]
#[allow(non_upper_case_globals, reason = "the interface prescribes the name")]
pub static pliant_entry: Shared<Library> = Shared(Library {
    size: size_of::<Library>(),
    abi_major: ABI_MAJOR,
    abi_minor: ABI_MINOR,
    init: Some(corotational_init),
    descriptor: Some(corotational_descriptor),
    create: Some(corotational_create),
});
