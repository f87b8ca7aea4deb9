//! The table of functions that plugins call on the host.

use crate::messages::{Inbox, receive};
use pliant_plugin_api::abi;
use std::ffi::c_void;
use std::sync::OnceLock;

/// The table for one instance; `data` is its inbox.
pub(crate) fn host_table(data: *mut c_void) -> abi::Host {
    abi::Host {
        size: size_of::<abi::Host>(),
        abi_major: abi::ABI_MAJOR,
        abi_minor: abi::ABI_MINOR,
        data,
        report: Some(receive),
    }
}

/// A host for the `init` of a library, before any instance; its messages are not read.
pub(crate) fn host_for_init() -> *const abi::Host {
    static HOST: OnceLock<abi::Shared<usize>> = OnceLock::new();
    let make = || {
        let inbox = Box::into_raw(Box::<Inbox>::default());
        abi::Shared(Box::into_raw(Box::new(host_table(inbox.cast()))) as usize)
    };
    HOST.get_or_init(make).0 as *const abi::Host
}
