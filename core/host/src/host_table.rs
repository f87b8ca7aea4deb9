//! The functions of the host that plugins call.

use crate::messages::{Inbox, receive};
use pliant_plugin_api::abi;
use std::ffi::c_void;
use std::sync::OnceLock;

/// The table of functions for one instance; `data` is its [`Inbox`].
pub(crate) fn host_table(data: *mut c_void) -> abi::Host {
    abi::Host {
        size: size_of::<abi::Host>(),
        abi_major: abi::ABI_MAJOR,
        abi_minor: abi::ABI_MINOR,
        data,
        report: Some(receive),
    }
}

/// The table for the `init` of a library, which has no instance yet; its messages are dropped.
pub(crate) fn host_for_init() -> *const abi::Host {
    static HOST: OnceLock<abi::Shared<usize>> = OnceLock::new();
    let make = || {
        let inbox = Box::into_raw(Box::<Inbox>::default());
        abi::Shared(Box::into_raw(Box::new(host_table(inbox.cast()))) as usize)
    };
    HOST.get_or_init(make).0 as *const abi::Host
}
