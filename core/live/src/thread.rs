//! Threads of a live session.

use std::io;
use std::thread::{Builder, JoinHandle};

/// Starts the thread `name`.
///
/// # Errors
/// The error of the system if it gives no thread, with the name.
pub(crate) fn start<R: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> R + Send + 'static,
) -> io::Result<JoinHandle<R>> {
    let named = |e: io::Error| io::Error::new(e.kind(), format!("the {name} thread cannot be started: {e}"));
    Builder::new().name(name.into()).spawn(work).map_err(named)
}
