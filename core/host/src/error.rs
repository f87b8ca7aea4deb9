//! Errors of plugins.

use pliant_solver::ForceError;
use std::path::PathBuf;
use thiserror::Error;

/// An error of a plugin. Every message names the file or the plugin.
#[derive(Debug, Error)]
pub enum HostError {
    /// No folder has a file for the plugin.
    #[error("no plugin `{name}`: looked for {files} in\n{places}")]
    NotFound {
        /// Name of the plugin in the scene.
        name: String,
        /// File names that were looked for.
        files: String,
        /// Folders that were searched, one per line, with the reason if one cannot be used.
        places: String,
    },
    /// A scene or recording names a library by its path, in a folder that was not allowed.
    #[error(
        "{}: a library that is named by its path runs its code here; if you trust it, allow its folder: `--allow-plugins {}`, in Python \
         `allow_plugins`",
        path.display(), folder.display()
    )]
    NotAllowed {
        /// Path of the library, links followed.
        path: PathBuf,
        /// Folder of the library.
        folder: PathBuf,
    },
    /// A folder that was allowed does not exist or is not a folder.
    #[error("{} (`--allow-plugins`): {reason}; allowed is a folder with plugins", folder.display())]
    AllowedFolder {
        /// The folder as it was given.
        folder: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Other users can change the library.
    #[error("{}: not opened: {reason}; allowed is a library that no other user can write to", path.display())]
    Unsafe {
        /// Path of the library.
        path: PathBuf,
        /// Who can change what.
        reason: String,
    },
    /// The dynamic linker refuses the file.
    #[error("{}: cannot be opened as a shared library: {reason}", path.display())]
    NotALibrary {
        /// Path of the library.
        path: PathBuf,
        /// Message of the linker.
        reason: String,
    },
    /// A shared library without the entry point of a plugin.
    #[error("{}: no symbol `pliant_entry`: a shared library, but not a pliant plugin", path.display())]
    NoEntry {
        /// Path of the library.
        path: PathBuf,
    },
    /// The library was made for another major version of the plugin interface.
    #[error("{}: made for plugin interface {found}, this host has {expected}; rebuild the plugin", path.display())]
    Abi {
        /// Path of the library.
        path: PathBuf,
        /// Version of the library.
        found: String,
        /// Version of this host.
        expected: String,
    },
    /// A table of the library has a missing or meaningless entry.
    #[error("{}: {reason}", path.display())]
    Malformed {
        /// Path of the library.
        path: PathBuf,
        /// The table, and what is wrong with it.
        reason: String,
    },
    /// The library has no plugin of that kind and name.
    #[error("{}: no {kind} `{id}` in this library; it has {offered}", path.display())]
    NoSuchPlugin {
        /// Path of the library.
        path: PathBuf,
        /// `grid`, `material`, `device` or `contact-law`.
        kind: &'static str,
        /// Id that was asked for.
        id: String,
        /// Plugins that the library has.
        offered: String,
    },
    /// A parameter of the scene does not fit the declaration.
    #[error("{plugin}: parameter `{key}`: {reason}")]
    Param {
        /// Id of the plugin.
        plugin: String,
        /// Key of the parameter, declared or not.
        key: String,
        /// What is wrong with the value, and what is allowed.
        reason: String,
    },
    /// The plugin refuses values of the scene.
    #[error("{plugin} ({}): {reason}", path.display())]
    Refused {
        /// Id of the plugin.
        plugin: String,
        /// File of the plugin.
        path: PathBuf,
        /// Message of the plugin.
        reason: String,
    },
    /// A call into the plugin failed.
    #[error("{plugin} ({}): {call}: {reason}", path.display())]
    Call {
        /// Id of the plugin.
        plugin: String,
        /// File of the plugin.
        path: PathBuf,
        /// Function of the plugin interface.
        call: &'static str,
        /// Meaning of the status, and message of the plugin.
        reason: String,
    },
}

impl HostError {
    /// Whether the input caused the error and not the plugin: a value of the scene was refused, or a path is not allowed.
    pub fn is_refusal(&self) -> bool {
        matches!(self, Self::Param { .. } | Self::Refused { .. } | Self::NotAllowed { .. } | Self::AllowedFolder { .. })
    }
}

impl From<HostError> for ForceError {
    fn from(error: HostError) -> Self {
        let HostError::Call { plugin, path, call, reason } = error else {
            return Self { model: "plugin".into(), call: "host", reason: error.to_string() };
        };
        Self { model: format!("{plugin} ({})", path.display()), call, reason }
    }
}
