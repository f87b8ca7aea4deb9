//! Files that are dropped on the window of an X server.
//!
//! The window library (winit 0.30) takes drops too. But it loses a whole list, without a word, where one URI has a host name, another scheme or one slash
//! (`file:/path`), is a comment, ends in a line feed alone, is not UTF-8 or names a file that is not there, and where the list comes later than the drop. So a
//! window of our own takes the messages in its place, which the protocol allows (`XdndProxy`). A source that knows no proxies still speaks to the library.
//!
//! Source: Lindahl and others, Drag-and-Drop Protocol for the X Window System, version 5.

#[cfg(target_os = "linux")]
mod target;
#[cfg(target_os = "linux")]
mod uri_list;

#[cfg(target_os = "linux")]
pub use target::take_drops;

use std::path::PathBuf;

/// What is dragged over the window, or dropped on it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DraggedFiles {
    /// Files of this machine.
    pub paths: Vec<PathBuf>,
    /// URIs of anything else.
    pub others: Vec<String>,
}

/// What a drag does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DragNews {
    /// These are over the window.
    Over(DraggedFiles),
    /// They have left it.
    Left,
    /// They were let go over it.
    Dropped(DraggedFiles),
}
