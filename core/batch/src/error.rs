//! Why a batch cannot be run or read.

use pliant_engine::scene::SceneError;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a batch cannot be run or read.
#[derive(Debug, Error)]
pub enum BatchError {
    /// The sweep file, or a base scene it names, says something it cannot.
    #[error(transparent)]
    Sweep(#[from] SceneError),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
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
    /// A journal that is no journal, or one of another program.
    #[error("{}: {reason}", path.display())]
    Journal {
        /// Path of the journal.
        path: PathBuf,
        /// What is wrong, and what is allowed.
        reason: String,
    },
    /// Something the caller asked for that cannot be had.
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
