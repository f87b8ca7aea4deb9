//! Checks of the paths that a run writes, before its first step: a run is not made whose results could not be kept.
//!
//! No output replaces an input of the run, the recording replaces no result, and only regular files are replaced: a rename would put a file in the
//! place of a device or a pipe, or of a link.

use crate::atomic::{error_at, folder_of};
use crate::inputs::models;
use crate::result_set::is_in_set;
use pliant_engine::scene::Source;
use pliant_engine::session::Session;
use std::fs::FileType;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Where a run writes.
#[derive(Clone, Copy, Debug)]
pub struct RunOutputs<'a> {
    /// Folder of the results.
    pub folder: &'a Path,
    /// File of the recording, if the run is recorded.
    pub recording: Option<&'a Path>,
}

/// Results in a folder, and no recording.
impl<'a, P: AsRef<Path> + ?Sized> From<&'a P> for RunOutputs<'a> {
    fn from(folder: &'a P) -> Self {
        Self { folder: folder.as_ref(), recording: None }
    }
}

impl RunOutputs<'_> {
    /// Checks the files `names` of the folder and the recording.
    ///
    /// # Errors
    /// Names the file, what is there and what is allowed.
    pub(crate) fn check(
        &self,
        names: impl Iterator<Item = String>,
        source: &Source,
        session: &Session,
    ) -> io::Result<()> {
        refuse_inputs(names.map(|name| self.folder.join(name)), source, session)?;
        let Some(recording) = self.recording else { return Ok(()) };
        check_file(recording, source, session)?;
        let (folder, file) = (resolve(self.folder), resolve(folder_of(recording)));
        let file = file.join(recording.file_name().unwrap_or_default());
        let text = if folder.starts_with(&file) {
            "the folder of the results or one above it; allowed is a file of another name"
        } else if file.strip_prefix(&folder).is_ok_and(is_in_set) {
            "a result of this run has this name; allowed is another name, or a file in another folder"
        } else {
            return Ok(());
        };
        Err(refused(recording, text))
    }
}

/// Checks a file that is written beside the results of a session: it is no input, and only a regular file is there to be replaced.
///
/// # Errors
/// Names the file, what is there and what is allowed.
pub(crate) fn check_file(path: &Path, source: &Source, session: &Session) -> io::Result<()> {
    refuse_inputs(std::iter::once(path.to_path_buf()), source, session)?;
    check_replaceable(path)
}

/// Checks that nothing is at `path`, or a regular file.
///
/// # Errors
/// Names the path, what is there and what is allowed.
pub fn check_replaceable(path: &Path) -> io::Result<()> {
    if path.file_name().is_none() {
        return Err(refused(path, "not the name of a file"));
    }
    let Ok(metadata) = path.symlink_metadata() else { return Ok(()) };
    match describe(metadata.file_type()) {
        None => Ok(()),
        Some(what) => {
            Err(refused(path, &format!("{what}, which is not replaced; allowed is a regular file or a new name")))
        }
    }
}

/// What a path leads to; `None` for a regular file.
fn describe(kind: FileType) -> Option<&'static str> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return Some("a pipe");
        }
        if kind.is_char_device() || kind.is_block_device() {
            return Some("a device");
        }
        if kind.is_socket() {
            return Some("a socket");
        }
    }
    match kind {
        kind if kind.is_symlink() => Some("a symbolic link"),
        kind if kind.is_dir() => Some("a folder"),
        kind if kind.is_file() => None,
        _ => Some("not a regular file"),
    }
}

/// Checks that no file of `outputs` is an input of the run: its scene, a model, an obstacle, a field, fibres, a recording or a plugin.
///
/// # Errors
/// Names the output and the kind of input.
pub(crate) fn refuse_inputs(
    outputs: impl Iterator<Item = PathBuf>,
    source: &Source,
    session: &Session,
) -> io::Result<()> {
    let files = models(session).map(|model| ("a model", model.document.name().to_path_buf()));
    let files = files.chain(session.inputs.loaded.iter().map(|l| ("a plugin", PathBuf::from(&l.path))));
    let files = files.chain(session.inputs.obstacle_files.iter().map(|path| ("an obstacle", path.clone())));
    let files = files.chain(
        session.inputs.field_files.iter().map(|path| ("a file of a field, of fibres or of a `fixed`", path.clone())),
    );
    let files = files.chain(session.inputs.recordings.iter().map(|hands| ("a recording", hands.path().to_path_buf())));
    let inputs: Vec<(&str, PathBuf)> = files
        .chain([("the scene", source.path.clone())])
        .filter_map(|(what, path)| Some((what, path.canonicalize().ok()?)))
        .collect();
    for output in outputs {
        // The folder of an output may not exist yet.
        let Ok(folder) = folder_of(&output).canonicalize() else { continue };
        let path = folder.join(output.file_name().unwrap_or_default());
        let path = path.canonicalize().unwrap_or(path);
        if let Some((what, _)) = inputs.iter().find(|(_, input)| *input == path) {
            let text = format!("{what} of this run, which its results do not replace; choose another file or folder");
            return Err(refused(&output, &text));
        }
    }
    Ok(())
}

/// A folder with links followed as far as it exists; the part that does not exist yet stays as it is.
fn resolve(folder: &Path) -> PathBuf {
    let Ok(absolute) = std::path::absolute(folder) else { return folder.into() };
    let there = absolute.ancestors().find_map(|above| Some((above, above.canonicalize().ok()?)));
    match there {
        Some((above, real)) => match absolute.strip_prefix(above) {
            Ok(rest) if !rest.as_os_str().is_empty() => real.join(rest),
            _ => real,
        },
        None => absolute,
    }
}

/// The error of a path that is not written.
fn refused(path: &Path, text: &str) -> io::Error {
    error_at(path, io::Error::new(ErrorKind::AlreadyExists, text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_and_new_names_are_replaceable() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("file"), "").unwrap();
        for name in ["file", "new", "absent/new"] {
            check_replaceable(&at(name)).unwrap();
        }
        let refused = |path: &Path| check_replaceable(path).unwrap_err().to_string();
        assert!(refused(folder.path()).contains("a folder"));
        assert!(refused(Path::new("..")).contains("not the name of a file"));
        #[cfg(unix)]
        {
            assert!(
                refused(Path::new("/dev/null")).starts_with("/dev/null: a device, which is not replaced; allowed is")
            );
            std::os::unix::fs::symlink("file", at("link")).unwrap();
            std::os::unix::fs::symlink("nowhere", at("broken")).unwrap();
            let _socket = std::os::unix::net::UnixListener::bind(at("socket")).unwrap();
            for (name, what) in [("link", "a symbolic link"), ("broken", "a symbolic link"), ("socket", "a socket")] {
                assert!(refused(&at(name)).contains(what), "{name}");
            }
        }
    }

    #[test]
    fn a_folder_is_resolved_as_far_as_it_exists() {
        let folder = tempfile::tempdir().unwrap();
        let real = folder.path().canonicalize().unwrap();
        assert_eq!(resolve(folder.path()), real);
        assert_eq!(resolve(&folder.path().join("a/b")), real.join("a/b"));
    }
}
