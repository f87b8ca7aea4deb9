//! Errors of batches.

use pliant_engine::scene::SceneError;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// An error of running or reading a batch.
#[derive(Debug, Error)]
pub enum BatchError {
    /// The sweep file or a base scene is invalid.
    #[error(transparent)]
    Sweep(#[from] SceneError),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// Another process works on the shard.
    #[error("{}: shard {shard} is being run by {holder}; wait for it to end, or end it", path.display())]
    Locked {
        /// Path of the journal.
        path: PathBuf,
        /// The shard, as `I/N`.
        shard: String,
        /// Process and host.
        holder: String,
    },
    /// The folder has results of the shard already.
    #[error("{}: has {rows} of this shard already; add --resume to do what is missing, or name another --out", path.display())]
    Exists {
        /// Path of the journal.
        path: PathBuf,
        /// Number of rows, in words.
        rows: String,
    },
    /// A file is not a journal, or a journal does not fit the sweep or the program.
    #[error("{}: {reason}", path.display())]
    Journal {
        /// Path of the journal.
        path: PathBuf,
        /// What is wrong, and what is allowed.
        reason: String,
    },
    /// The caller's request cannot be fulfilled, with the reason.
    #[error("{0}")]
    Input(String),
}

impl BatchError {
    /// An error of the file system at `path`.
    pub(crate) fn io(path: &Path, source: io::Error) -> Self {
        Self::Io { path: path.to_path_buf(), source }
    }

    /// A closure that makes [`BatchError::io`] at `path`.
    pub(crate) fn at(path: &Path) -> impl Fn(io::Error) -> Self + '_ {
        move |source| Self::io(path, source)
    }
}
