//! What plugins see of the host.

use super::report::{Inbox, receive};
use pliant_plugin_api::abi;
use std::ffi::c_void;
use std::sync::OnceLock;

/// The table an instance is given; `data` is its inbox.
pub(super) fn host_table(data: *mut c_void) -> abi::Host {
    abi::Host {
        size: size_of::<abi::Host>(),
        abi_major: abi::ABI_MAJOR,
        abi_minor: abi::ABI_MINOR,
        data,
        report: Some(receive),
    }
}

/// A host for a library's `init`, before any instance: what is said goes to an inbox nobody reads.
pub(super) fn quiet_host() -> *const abi::Host {
    static HOST: OnceLock<abi::Shared<usize>> = OnceLock::new();
    let make = || {
        let inbox = Box::into_raw(Box::<Inbox>::default());
        abi::Shared(Box::into_raw(Box::new(host_table(inbox.cast()))) as usize)
    };
    HOST.get_or_init(make).0 as *const abi::Host
}
