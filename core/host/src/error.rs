//! Why a plugin cannot be used.

use pliant_solver::ForceError;
use std::path::PathBuf;
use thiserror::Error;

/// Every reason names the file or the plugin.
#[derive(Debug, Error)]
pub enum HostError {
    /// No file of that name in any folder.
    #[error("no plugin `{name}`: looked for {files} in\n{places}")]
    NotFound {
        /// As the scene names it.
        name: String,
        /// The file names that would have done.
        files: String,
        /// The folders, one a line, with what is wrong with each.
        places: String,
    },
    /// The dynamic linker refuses the file.
    #[error("{}: cannot be opened as a shared library: {reason}", path.display())]
    NotALibrary {
        /// The file.
        path: PathBuf,
        /// What the linker says.
        reason: String,
    },
    /// A library, but not a plugin.
    #[error("{}: no symbol `pliant_entry`: a shared library, but not a pliant plugin", path.display())]
    NoEntry {
        /// The file.
        path: PathBuf,
    },
    /// Made for another major version of the border.
    #[error("{}: made for plugin interface {found}, this host has {expected}; rebuild the plugin", path.display())]
    Abi {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: String,
        /// Ours.
        expected: String,
    },
    /// Something in a table is missing or makes no sense.
    #[error("{}: {reason}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Which table, and what.
        reason: String,
    },
    /// The library has no such plugin.
    #[error("{}: no {kind} `{id}` in it; it has {offered}", path.display())]
    NoSuchPlugin {
        /// The file.
        path: PathBuf,
        /// grid, material or device.
        kind: &'static str,
        /// What was asked for.
        id: String,
        /// What there is.
        offered: String,
    },
    /// A parameter of the scene does not fit the declaration.
    #[error("{plugin}: parameter `{key}`: {reason}")]
    Param {
        /// Its id.
        plugin: String,
        /// The key, declared or not.
        key: String,
        /// What is wrong, and what is allowed.
        reason: String,
    },
    /// It works, but not with what the scene gives it.
    #[error("{plugin} ({}): {reason}", path.display())]
    Refused {
        /// Its id.
        plugin: String,
        /// Its file.
        path: PathBuf,
        /// What it says.
        reason: String,
    },
    /// A call failed.
    #[error("{plugin} ({}): {call}: {reason}", path.display())]
    Call {
        /// Its id.
        plugin: String,
        /// Its file.
        path: PathBuf,
        /// Which function.
        call: &'static str,
        /// The status, and what the plugin said of it.
        reason: String,
    },
}

impl HostError {
    /// Whether the plugin only refuses what it is given.
    pub fn is_refusal(&self) -> bool {
        matches!(self, Self::Param { .. } | Self::Refused { .. })
    }
}

impl From<HostError> for ForceError {
    fn from(error: HostError) -> Self {
        match error {
            HostError::Call { plugin, path, call, reason } => {
                Self { model: format!("{plugin} ({})", path.display()), call, reason }
            }
            error => Self { model: "plugin".into(), call: "host", reason: error.to_string() },
        }
    }
}
