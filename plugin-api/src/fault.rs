//! The error type of plugin functions.

use crate::abi::Status;
use std::borrow::Cow;

/// The error of a plugin function: a status for the host and a reason for people. Inside a step, use a `'static` reason, which does
/// not allocate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The code the host receives.
    pub status: Status,
    /// One line of text; the host keeps its first 255 bytes. Empty: nothing is reported.
    pub reason: Cow<'static, str>,
}

impl Fault {
    /// An argument or parameter is outside what is allowed.
    pub fn bad_argument(reason: impl Into<Cow<'static, str>>) -> Self {
        Self { status: Status::BAD_ARGUMENT, reason: reason.into() }
    }

    /// The plugin does not offer what was asked.
    pub fn unsupported(reason: impl Into<Cow<'static, str>>) -> Self {
        Self { status: Status::UNSUPPORTED, reason: reason.into() }
    }

    /// A result is not finite.
    pub fn diverged(reason: impl Into<Cow<'static, str>>) -> Self {
        Self { status: Status::DIVERGED, reason: reason.into() }
    }

    /// A file or device failed.
    pub fn io(reason: impl Into<Cow<'static, str>>) -> Self {
        Self { status: Status::IO, reason: reason.into() }
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.status.meaning(), self.reason)
    }
}

impl std::error::Error for Fault {}
