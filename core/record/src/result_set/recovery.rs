//! What a process that was killed has left: a staging folder, or a set whose files were being moved.

use super::files::{files_below, is_result, is_temporary, listed_by};
use super::{FRAMES, SUMMARY};
use crate::atomic::{error_at, folder_of, sync_folder};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Name of the folder with a complete set whose files are being moved.
pub(super) const COMMITTED: &str = "results.pliant-committed";
/// The summary of the set that is being replaced, in the folder of the committed one.
pub(super) const OLD_SUMMARY: &str = "summary.json.pliant-old.partial";

/// Completes a set in `folder` whose files were being moved when the process ended; does nothing without one.
pub(super) fn complete(folder: &Path) -> io::Result<()> {
    let committed = folder.join(COMMITTED);
    // A link is not followed.
    if !committed.symlink_metadata().is_ok_and(|metadata| metadata.is_dir()) {
        return Ok(());
    }
    let files = files_below(&committed).map_err(|e| error_at(&committed, e))?;
    if files.contains(Path::new(SUMMARY)) {
        // The old summary is moved first and kept until every file it lists has been replaced or removed.
        let (old, summary) = (committed.join(OLD_SUMMARY), folder.join(SUMMARY));
        if !old.exists() && summary.exists() {
            std::fs::rename(&summary, &old).map_err(|e| error_at(&summary, e))?;
        }
        let new = listed_by(&committed.join(SUMMARY), &committed);
        for file in listed_by(&old, folder).difference(&new) {
            let path = folder.join(file);
            remove_if_there(&path).map_err(|e| error_at(&path, e))?;
        }
        let rest = files.iter().filter(|file| is_result(file) && *file != Path::new(SUMMARY));
        for file in rest.chain([&PathBuf::from(SUMMARY)]) {
            let path = folder.join(file);
            let above = folder_of(&path);
            std::fs::create_dir_all(above).map_err(|e| error_at(above, e))?;
            std::fs::rename(committed.join(file), &path).map_err(|e| error_at(&path, e))?;
        }
    }
    discard(&committed, folder).map_err(|e| error_at(&committed, e))?;
    let _ = std::fs::remove_dir(folder.join(FRAMES));
    sync_folder(folder);
    Ok(())
}

/// Removes the staging folder of a process that has ended. If the folder of results is missing, as between two renames on a system that cannot
/// exchange folders, a complete set becomes the folder of results.
pub(super) fn recover(stage: &Path, folder: &Path) -> io::Result<()> {
    if !folder.exists() && stage.join(SUMMARY).is_file() && folder_of(stage) == folder_of(folder) {
        return std::fs::rename(stage, folder).map_err(|e| error_at(folder, e));
    }
    discard(stage, folder).map_err(|e| error_at(stage, e))
}

/// Removes the results and temporary files in `stage`, moves everything else into `folder`, and removes `stage` if nothing is left in it.
pub(super) fn discard(stage: &Path, folder: &Path) -> io::Result<()> {
    let frames = stage.join(FRAMES);
    for file in files_below(stage)?.iter().filter(|file| is_result(file) || is_temporary(file)) {
        remove_if_there(&stage.join(file))?;
    }
    let _ = std::fs::remove_dir(frames);
    for entry in stage.read_dir()?.flatten() {
        let to = folder.join(entry.file_name());
        if folder.is_dir() && to.symlink_metadata().is_err() {
            std::fs::rename(entry.path(), to)?;
        }
    }
    // Files whose names exist in the folder of results stay.
    match std::fs::remove_dir(stage) {
        Err(error) if !matches!(error.kind(), ErrorKind::DirectoryNotEmpty | ErrorKind::NotFound) => Err(error),
        _ => Ok(()),
    }
}

/// Removes a file if it exists.
pub(super) fn remove_if_there(path: &Path) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
