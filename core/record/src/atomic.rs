//! Files and folders that appear under their name whole or not at all.
//!
//! Each is written under a random name beside its final one, `NAME.pliant-XXXXXX.partial`, and renamed when it is whole. The name is
//! created exclusively, so a link planted there is not followed. The writer holds an advisory lock on it; what a
//! killed program left behind is unlocked, which is how [`remove_leftovers`] tells it from a file that is being written.

use std::ffi::OsString;
use std::fs::{File, Permissions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile, TempDir};

/// Part of every temporary name, before its random letters.
const MARK: &str = ".pliant-";
/// End of every temporary name.
const SUFFIX: &str = ".partial";
/// Bytes that are collected before they go to the file.
const BUFFER: usize = 1 << 16;
/// How often a temporary file is made anew because a concurrent [`remove_leftovers`] took it before it was locked.
const ATTEMPTS: usize = 8;

/// A file that is written under a temporary name beside its final one. Dropping it unfinished removes it.
pub struct AtomicFile {
    path: PathBuf,
    writer: BufWriter<NamedTempFile>,
}

impl AtomicFile {
    /// Begins the file that will be `path`, making its folder if there is none.
    ///
    /// # Errors
    /// What the file system says, with the path.
    pub fn create(path: &Path) -> io::Result<Self> {
        let folder = folder_of(path);
        std::fs::create_dir_all(folder).map_err(|e| error_at(folder, e))?;
        for _ in 0..ATTEMPTS {
            let name = temporary_prefix(path);
            let mut builder = Builder::new();
            let file = with_usual_permissions(builder.prefix(&name).suffix(SUFFIX), 0o666)
                .tempfile_in(folder)
                .map_err(|e| error_at(path, e))?;
            if is_ours(file.as_file(), file.path()) {
                return Ok(Self { path: path.to_path_buf(), writer: BufWriter::with_capacity(BUFFER, file) });
            }
        }
        Err(error_at(path, io::Error::other("its temporary file was removed each time it was made")))
    }

    /// Puts the file in the place of whatever had its name.
    ///
    /// # Errors
    /// What the file system says, with the path; what was there before stays.
    pub fn finish(self) -> io::Result<()> {
        let path = self.path.clone();
        self.finish_as(&path)
    }

    /// Puts the file under another name of the same file system.
    ///
    /// # Errors
    /// As for [`AtomicFile::finish`].
    pub fn finish_as(self, path: &Path) -> io::Result<()> {
        let file = self.writer.into_inner().map_err(|e| error_at(&self.path, e.into_error()))?;
        file.as_file().sync_all().map_err(|e| error_at(&self.path, e))?;
        file.persist(path).map(drop).map_err(|e| error_at(path, e.error))
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// A folder that is filled under a temporary name beside its final one. Dropping it unfinished removes it and what is in it.
pub(crate) struct AtomicFolder {
    folder: TempDir,
    /// Holds the lock that [`remove_leftovers`] asks for; `None` where the system does not open folders.
    _lock: Option<File>,
}

impl AtomicFolder {
    /// Begins the folder that will be `path`, making the folders above it.
    ///
    /// # Errors
    /// What the file system says, with the path.
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        let above = folder_of(path);
        std::fs::create_dir_all(above).map_err(|e| error_at(above, e))?;
        for _ in 0..ATTEMPTS {
            let folder = temporary_folder(path)?;
            let Ok(lock) = File::open(folder.path()) else { return Ok(Self { folder, _lock: None }) };
            if is_ours(&lock, folder.path()) {
                return Ok(Self { folder, _lock: Some(lock) });
            }
        }
        Err(error_at(path, io::Error::other("its temporary folder was removed each time it was made")))
    }

    /// Where the folder is while it is filled.
    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Puts the folder in the place of whatever had the name `path` in the same file system. A folder with something in it cannot
    /// be written over, so the old one is first moved into a temporary folder beside it, and back if the new one cannot take its
    /// place.
    ///
    /// # Errors
    /// What the file system says, with the path; what was there before stays.
    pub(crate) fn finish_as(self, path: &Path) -> io::Result<()> {
        let aside = temporary_folder(path)?;
        let old = aside.path().join("old");
        let had_old = match std::fs::rename(path, &old) {
            Ok(()) => true,
            Err(error) if error.kind() == io::ErrorKind::NotFound => false,
            Err(error) => return Err(error_at(path, error)),
        };
        if let Err(error) = std::fs::rename(self.folder.path(), path) {
            if had_old && std::fs::rename(&old, path).is_err() {
                // What cannot be put back is not removed either.
                let kept = aside.keep().join("old");
                return Err(error_at(path, io::Error::other(format!("{error}; the old one is in {}", kept.display()))));
            }
            return Err(error_at(path, error));
        }
        // It has its own name now: nothing is left to remove.
        let _ = self.folder.keep();
        aside.close().map_err(|e| error_at(path, e))
    }
}

/// Removes temporary files and folders in `folder` that no running program writes: those whose lock can be had. Does nothing where the
/// file system has no locks, and does not look into other folders.
pub fn remove_leftovers(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let (name, path) = (entry.file_name(), entry.path());
        let name = name.to_string_lossy();
        if !name.ends_with(SUFFIX) || !name.contains(MARK) {
            continue;
        }
        // The type of the entry itself: a link is neither a file nor a folder.
        let Ok(kind) = entry.file_type() else { continue };
        if !(kind.is_file() || kind.is_dir()) {
            continue;
        }
        let Ok(file) = File::open(&path) else { continue };
        if file.try_lock().is_ok() {
            // Removed while the lock is held, so that one who makes such a file and then locks it sees that it is gone.
            let _ = if kind.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
        }
    }
}

/// Locks a new temporary file or folder; false if a concurrent [`remove_leftovers`] took it before. Where the file system has no
/// locks it stays unlocked.
fn is_ours(file: &File, path: &Path) -> bool {
    let _ = file.lock();
    path.symlink_metadata().is_ok()
}

/// A folder of random name beside `path`.
fn temporary_folder(path: &Path) -> io::Result<TempDir> {
    let name = temporary_prefix(path);
    let mut builder = Builder::new();
    with_usual_permissions(builder.prefix(&name).suffix(SUFFIX), 0o777)
        .tempdir_in(folder_of(path))
        .map_err(|e| error_at(path, e))
}

/// The name of `path` and the mark, before the random letters.
fn temporary_prefix(path: &Path) -> OsString {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(MARK);
    name
}

/// The folder a path is in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Gives a file or folder `mode`, less the user's mask, as other programs do: temporary files are private by default.
#[cfg(unix)]
fn with_usual_permissions<'b, 'n>(builder: &'b mut Builder<'n, 'n>, mode: u32) -> &'b mut Builder<'n, 'n> {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(Permissions::from_mode(mode))
}

/// Leaves the permissions as the system gives them.
#[cfg(not(unix))]
fn with_usual_permissions<'b, 'n>(builder: &'b mut Builder<'n, 'n>, _mode: u32) -> &'b mut Builder<'n, 'n> {
    builder
}

/// The same error, naming the file.
pub(crate) fn error_at(path: &Path, error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of entries in a folder.
    fn count(folder: &Path) -> usize {
        folder.read_dir().unwrap().count()
    }

    #[test]
    fn a_folder_replaces_an_older_one_or_leaves_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frames");
        for (i, finished) in [true, false, true].into_iter().enumerate() {
            let new = AtomicFolder::create(&path).unwrap();
            std::fs::write(new.path().join(format!("{i}.obj")), "").unwrap();
            if finished {
                new.finish_as(&path).unwrap()
            } else {
                drop(new)
            }
            let names: Vec<_> = path.read_dir().unwrap().map(|e| e.unwrap().file_name()).collect();
            assert_eq!(names, [["0.obj", "0.obj", "2.obj"][i]]);
            assert_eq!(count(folder.path()), 1, "nothing else is left");
        }
    }

    #[test]
    fn a_folder_that_cannot_take_its_place_leaves_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frames");
        std::fs::create_dir(&path).unwrap();
        std::fs::write(path.join("old.obj"), "").unwrap();
        let new = AtomicFolder::create(&path).unwrap();
        std::fs::remove_dir(new.path()).unwrap();
        let text = new.finish_as(&path).unwrap_err().to_string();
        assert!(text.contains("frames"), "{text}");
        assert!(path.join("old.obj").exists() && count(folder.path()) == 1);
    }

    #[test]
    fn an_unfinished_file_leaves_nothing_and_what_was_there_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/result.txt");
        let mut first = AtomicFile::create(&path).unwrap();
        first.write_all(b"whole").unwrap();
        first.finish().unwrap();
        let mut second = AtomicFile::create(&path).unwrap();
        second.write_all(b"ha").unwrap();
        drop(second);
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
        assert_eq!(count(path.parent().unwrap()), 1);
    }

    #[test]
    fn leftovers_of_killed_programs_are_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        // A killed program leaves its files, and no lock on them.
        std::fs::write(at("summary.json.pliant-AbCd12.partial"), "").unwrap();
        std::fs::create_dir_all(at("frames.pliant-AbCd12.partial/deep")).unwrap();
        std::fs::write(at("mine.partial"), "of the user").unwrap();
        std::fs::write(at("summary.json"), "of before").unwrap();
        let live = (AtomicFile::create(&at("summary.json")).unwrap(), AtomicFolder::create(&at("frames")).unwrap());
        remove_leftovers(folder.path());
        let kept: Vec<_> = folder.path().read_dir().unwrap().map(|e| e.unwrap().path()).collect();
        assert!(kept.len() == 4 && kept.iter().all(|path| !path.to_string_lossy().contains("AbCd12")), "{kept:?}");
        live.0.finish().unwrap();
        live.1.finish_as(&at("frames")).unwrap();
        assert_eq!((std::fs::read(at("summary.json")).unwrap(), count(folder.path())), (vec![], 3));
    }

    #[test]
    #[cfg(unix)]
    fn results_can_be_read_by_whoever_reads_other_files_there() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("a"), folder.path().join("b"));
        AtomicFile::create(&ours).unwrap().finish().unwrap();
        std::fs::write(&plain, "").unwrap();
        let mode = |path: &Path| path.metadata().unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
