//! Recent files: what was opened last, the newest first, in a file beside the autosaves.

use crate::strings;
use pliant_record::AtomicFile;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Name of the file.
const FILE: &str = "recent.json";
/// Most files that are kept.
const MOST: usize = 10;

/// The files that were opened last, the newest first, as absolute paths; those that are no longer there are left out.
///
/// # Errors
/// A list that cannot be read or is damaged, with its path, line and column.
pub fn recent_files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut files = read(folder)?;
    files.retain(|file| file.is_file());
    Ok(files)
}

fn read(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let path = folder.join(FILE);
    let wrong = |error: &dyn std::fmt::Display| io::Error::other(format!("{}: {error}", path.display()));
    match std::fs::read(&path) {
        Ok(bytes) => serde_json::from_slice(&bytes).map_err(|error| wrong(&strings::to_mend(&error))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(wrong(&error)),
    }
}

/// Puts a file that was opened first in the list.
///
/// # Errors
/// That of the file system, with the path. A damaged list is left as it is.
pub fn add_recent_file(folder: &Path, opened: &Path) -> io::Result<()> {
    let (before, opened) = (read(folder)?, std::path::absolute(opened)?);
    if before.first() == Some(&opened) {
        return Ok(());
    }
    let others = before.into_iter().filter(|file| *file != opened).take(MOST - 1);
    let files: Vec<PathBuf> = std::iter::once(opened.clone()).chain(others).collect();
    std::fs::create_dir_all(folder)?;
    let mut file = AtomicFile::create_and_clean(&folder.join(FILE))?;
    file.write_all(&serde_json::to_vec_pretty(&files)?)?;
    file.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_comes_first_once_and_what_is_gone_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let state = folder.path().join("state");
        assert_eq!(recent_files(&state).unwrap(), [""; 0].map(PathBuf::from), "nothing was opened yet");
        let path = |number: usize| folder.path().join(format!("{number}.obj"));
        for number in 0..MOST + 3 {
            std::fs::write(path(number), "").unwrap();
            add_recent_file(&state, &path(number)).unwrap();
        }
        add_recent_file(&state, &path(5)).unwrap();
        let expected: Vec<_> = [5, 12, 11, 10, 9, 8, 7, 6, 4, 3].map(path).into();
        assert_eq!(recent_files(&state).unwrap(), expected);
        std::fs::remove_file(path(11)).unwrap();
        assert!(!recent_files(&state).unwrap().contains(&path(11)));
    }

    #[test]
    fn a_damaged_list_is_named_and_left_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join(FILE);
        std::fs::write(&list, "[\n1").unwrap();
        for error in
            [recent_files(folder.path()).unwrap_err(), add_recent_file(folder.path(), Path::new("a.obj")).unwrap_err()]
        {
            let text = error.to_string();
            assert!(text.contains("recent.json") && text.contains("line 2"), "{text}");
        }
        assert_eq!(std::fs::read_to_string(&list).unwrap(), "[\n1");
    }
}
