//! Why a plugin could not do what it was asked.

use crate::abi::Status;
use std::borrow::Cow;

/// A status and, for people, its reason. Inside a step use a `'static` reason: nothing is allocated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What crosses the border.
    pub status: Status,
    /// One line; the host keeps its first 255 bytes.
    pub reason: Cow<'static, str>,
}

impl Fault {
    /// An argument or parameter outside of what is allowed.
    pub fn bad_argument(reason: impl Into<Cow<'static, str>>) -> Self {
        Self { status: Status::BAD_ARGUMENT, reason: reason.into() }
    }

    /// Something this plugin does not offer.
    pub fn unsupported(reason: impl Into<Cow<'static, str>>) -> Self {
        Self { status: Status::UNSUPPORTED, reason: reason.into() }
    }

    /// A result that is not finite.
    pub fn diverged(reason: impl Into<Cow<'static, str>>) -> Self {
        Self { status: Status::DIVERGED, reason: reason.into() }
    }

    /// A file or device that failed.
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
