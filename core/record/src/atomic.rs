//! Files and folders that appear under their name whole or not at all.
//!
//! Each is written under a random name beside its final one, `NAME.pliant-XXXXXX.partial`, and renamed when it is whole; then the folder is
//! flushed. The name is created exclusively, so a link planted there is not followed. The writer holds an advisory lock on it; what a
//! killed program left behind is unlocked, which is how [`remove_leftovers`] tells it from a file that is being written.

use std::ffi::{OsStr, OsString};
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
    /// The name it will have.
    path: PathBuf,
    /// Its name in errors.
    shown: PathBuf,
    writer: BufWriter<NamedTempFile>,
}

impl AtomicFile {
    /// Begins the file that will be `path`, making its folder if there is none.
    ///
    /// # Errors
    /// What the file system says, with the path.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::create_shown(path, path)
    }

    /// The same, with another name in errors: for a file in a folder that will be renamed.
    ///
    /// # Errors
    /// As for [`AtomicFile::create`].
    pub(crate) fn create_shown(path: &Path, shown: &Path) -> io::Result<Self> {
        let folder = folder_of(path);
        std::fs::create_dir_all(folder).map_err(|e| error_at(folder, e))?;
        for _ in 0..ATTEMPTS {
            let name = temporary_prefix(path);
            let mut builder = Builder::new();
            let file = with_usual_permissions(builder.prefix(&name).suffix(SUFFIX), 0o666)
                .tempfile_in(folder)
                .map_err(|e| error_at(shown, e))?;
            if is_ours(file.as_file(), file.path()) {
                let (path, shown) = (path.to_path_buf(), shown.to_path_buf());
                return Ok(Self { path, shown, writer: BufWriter::with_capacity(BUFFER, file) });
            }
        }
        Err(error_at(shown, io::Error::other("its temporary file was removed each time it was made")))
    }

    /// Puts the file in the place of whatever had its name.
    ///
    /// # Errors
    /// What the file system says, with the path; what was there before stays.
    pub fn finish(self) -> io::Result<()> {
        let Self { path, shown, writer } = self;
        let file = writer.into_inner().map_err(|e| error_at(&shown, e.into_error()))?;
        file.as_file().sync_all().map_err(|e| error_at(&shown, e))?;
        file.persist(&path).map_err(|e| error_at(&shown, e.error))?;
        sync_folder(folder_of(&path));
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes).map_err(|e| error_at(&self.shown, e))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush().map_err(|e| error_at(&self.shown, e))
    }
}

/// A folder that is filled under a temporary name beside its final one. Dropping it unfinished removes it and what is in it.
pub(crate) struct AtomicFolder {
    folder: TempDir,
    /// Holds the lock that tells it from what a killed program has left; `None` where the system does not open folders.
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

    /// Leaves the folder where it is when this is dropped, unlocked.
    #[cfg(test)]
    pub(crate) fn keep(self) -> PathBuf {
        self.folder.keep()
    }
}

/// Removes temporary files and folders in `folder` that no running program writes: those whose lock can be had. Does nothing where the
/// file system has no locks, and does not look into other folders.
pub fn remove_leftovers(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let (name, path) = (entry.file_name(), entry.path());
        if !is_temporary_name(&name) {
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

/// Temporary folders beside `path`, of this program or one that was killed, for what will have its name. Links are none.
pub(crate) fn temporaries(path: &Path) -> Vec<PathBuf> {
    let start = temporary_prefix(path);
    let entries = std::fs::read_dir(folder_of(path)).into_iter().flatten().flatten();
    let is_one = |entry: &std::fs::DirEntry| {
        let name = entry.file_name();
        let begins = name.as_encoded_bytes().starts_with(start.as_encoded_bytes());
        begins && is_temporary_name(&name) && entry.file_type().is_ok_and(|kind| kind.is_dir())
    };
    entries.filter(is_one).map(|entry| entry.path()).collect()
}

/// Whether a file or folder of this name is one that is, or was, being written.
pub(crate) fn is_temporary_name(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    name.ends_with(SUFFIX) && name.contains(MARK)
}

/// Has the names in a folder on the disk. Systems that cannot do it for folders have no need for it.
pub(crate) fn sync_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
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

/// The same error, naming the file, unless it does so already.
pub(crate) fn error_at(path: &Path, error: io::Error) -> io::Error {
    let (path, text) = (path.display().to_string(), error.to_string());
    if text.starts_with(&format!("{path}: ")) { error } else { io::Error::new(error.kind(), format!("{path}: {text}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of entries in a folder.
    fn count(folder: &Path) -> usize {
        folder.read_dir().unwrap().count()
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
        drop(live.1);
        assert_eq!((std::fs::read(at("summary.json")).unwrap(), count(folder.path())), (vec![], 2));
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
