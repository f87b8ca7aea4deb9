//! Flushing of a set of results to the disk.

use super::{FRAMES, files_below};
use crate::atomic::{error_at, sync_folder};
use std::fs::File;
use std::io;
use std::path::Path;

/// Number of files from which on the file system is flushed as a whole first: one by one they take a few milliseconds each, which adds up.
const MANY_FILES: usize = 64;

/// Flushes the files of a staging folder; errors call it `shown`.
///
/// # Errors
/// The error of the file system, with the file.
pub(super) fn flush_files(folder: &Path, shown: &Path) -> io::Result<()> {
    let files = files_below(folder).map_err(|e| error_at(shown, e))?;
    if files.len() > MANY_FILES {
        sync_file_system(folder);
    }
    for file in files {
        let opened = File::options().write(true).open(folder.join(&file));
        opened.and_then(|opened| opened.sync_all()).map_err(|e| error_at(&shown.join(file), e))?;
    }
    Ok(())
}

/// Flushes the entries of a staging folder and of its `frames` to the disk; the files themselves were flushed by [`flush_files`].
pub(super) fn sync_tree(folder: &Path) -> io::Result<()> {
    sync_folder(&folder.join(FRAMES));
    sync_folder(folder);
    Ok(())
}

/// Flushes the file system with a folder. It tells no errors: each file is flushed after it, which then has nothing left to do.
#[cfg(target_os = "linux")]
fn sync_file_system(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = rustix::fs::syncfs(&folder);
    }
}

/// Not possible on this system.
#[cfg(not(target_os = "linux"))]
fn sync_file_system(_folder: &Path) {}
