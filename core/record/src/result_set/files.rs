//! Which files belong to a set of results: by the list in its summary, and by their names.

use super::{FRAMES, INTERRUPTED, SUMMARY};
use crate::output::OUTPUTS;
use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

/// Files of the set in `folder` by its summary: those with names of results, relative to it. A summary of an earlier version has no list; then
/// all files with names of results count.
pub(super) fn listed(folder: &Path) -> BTreeSet<PathBuf> {
    listed_by(&folder.join(SUMMARY), folder)
}

/// Files of the set in `folder` that the summary at a path lists.
pub(super) fn listed_by(summary: &Path, folder: &Path) -> BTreeSet<PathBuf> {
    let text = std::fs::read(summary).unwrap_or_default();
    let Ok(summary) = serde_json::from_slice::<serde_json::Value>(&text) else { return BTreeSet::new() };
    let is_ours = summary["program"].as_str().is_some_and(|program| program.starts_with("pliant "));
    match summary["files"].as_array() {
        _ if !is_ours => BTreeSet::new(),
        Some(files) => {
            let files = files.iter().filter_map(|file| file.as_str()).map(PathBuf::from);
            files.chain([SUMMARY.into()]).filter(|file| is_result(file)).collect()
        }
        None => files_below(folder).unwrap_or_default().into_iter().filter(|file| is_result(file)).collect(),
    }
}

/// Whether a path, relative to a folder of results, has the name of a result.
pub(super) fn is_result(file: &Path) -> bool {
    file == Path::new(SUMMARY) || OUTPUTS.iter().any(|kind| kind.names.contains(file))
}

/// Whether a path, relative to a folder of results, may be a file or folder of a set, of a complete or an interrupted run.
pub(crate) fn is_in_set(path: &Path) -> bool {
    let folders = [FRAMES, INTERRUPTED].map(Path::new);
    let path = path.strip_prefix(INTERRUPTED).ok().filter(|below| !below.as_os_str().is_empty()).unwrap_or(path);
    folders.contains(&path) || is_result(path)
}

/// Whether a file has the name of a temporary file.
pub(super) fn is_temporary(file: &Path) -> bool {
    file.file_name().is_some_and(crate::atomic::is_temporary_name)
}

/// Files and links in a folder and in its folder `frames`, relative to it. Other folders do not belong to a set.
pub(crate) fn files_below(folder: &Path) -> io::Result<BTreeSet<PathBuf>> {
    let mut files = BTreeSet::new();
    for below in ["", FRAMES] {
        let entries = match folder.join(below).read_dir() {
            Ok(entries) => entries,
            Err(_) if below == FRAMES => continue,
            Err(error) => return Err(error),
        };
        for entry in entries {
            let entry = entry?;
            if !entry.file_type()?.is_dir() {
                files.insert(Path::new(below).join(entry.file_name()));
            }
        }
    }
    Ok(files)
}
