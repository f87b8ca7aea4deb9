//! Atomic writing of files and folders: under its final name each is complete or does not exist.
//!
//! Each is written under a random name beside its final one, `NAME.pliant-XXXXXX.partial`, and renamed when it is complete; then the folder is
//! flushed. The temporary file is created exclusively, so a link with its name is not followed. The writer holds an advisory lock on it. The
//! files of a killed program have no lock, which is how [`remove_leftovers`] recognises them.

use std::ffi::{OsStr, OsString};
use std::fs::{File, Permissions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile, TempDir};

/// Part of every temporary name, before its random letters.
const MARK: &str = ".pliant-";
/// End of every temporary name.
const SUFFIX: &str = ".partial";
/// Size of the write buffer, bytes.
const BUFFER: usize = 1 << 16;
/// Largest number of attempts to create a temporary file that a concurrent [`remove_leftovers`] removes before it is locked.
const ATTEMPTS: usize = 8;

/// A file that is written under a temporary name and renamed by [`AtomicFile::finish`]. Dropping it unfinished removes it.
pub struct AtomicFile {
    /// Its final path.
    path: PathBuf,
    /// Its path in errors.
    shown: PathBuf,
    /// The temporary file.
    writer: BufWriter<NamedTempFile>,
    /// Whether it is flushed to the disk before it gets its name.
    is_flushed: bool,
}

impl AtomicFile {
    /// Begins the file that will be `path`; creates its folder.
    ///
    /// # Errors
    /// The error of the file system, with the path.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::create_shown(path, path)
    }

    /// As [`AtomicFile::create`]; removes what killed programs have left in its folder ([`remove_leftovers`]).
    ///
    /// # Errors
    /// As for [`AtomicFile::create`].
    pub fn create_and_clean(path: &Path) -> io::Result<Self> {
        let file = Self::create(path)?;
        remove_leftovers(folder_of(path));
        Ok(file)
    }

    /// As [`AtomicFile::create_shown`], for one of the files of a folder that its user flushes to the disk, all together.
    ///
    /// # Errors
    /// As for [`AtomicFile::create`].
    pub(crate) fn create_staged(path: &Path, shown: &Path) -> io::Result<Self> {
        Ok(Self { is_flushed: false, ..Self::create_shown(path, shown)? })
    }

    /// As [`AtomicFile::create`], with another path in errors, for a file in a folder that will be renamed.
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
            if lock_new(file.as_file(), file.path()) {
                let (path, shown) = (path.to_path_buf(), shown.to_path_buf());
                let writer = BufWriter::with_capacity(BUFFER, file);
                return Ok(Self { path, shown, writer, is_flushed: true });
            }
        }
        Err(error_at(shown, io::Error::other("its temporary file was removed each time it was created")))
    }

    /// Gives the file its final path, replacing a file that was there.
    ///
    /// # Errors
    /// The error of the file system, with the path; a file that was there stays.
    pub fn finish(self) -> io::Result<()> {
        let Self { path, shown, writer, is_flushed } = self;
        let file = writer.into_inner().map_err(|e| error_at(&shown, e.into_error()))?;
        if is_flushed {
            file.as_file().sync_all().map_err(|e| error_at(&shown, e))?;
        }
        file.persist(&path).map_err(|e| error_at(&shown, e.error))?;
        if is_flushed {
            sync_folder(folder_of(&path));
        }
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

/// A folder under a temporary name beside its final one, to be renamed by its user. Dropping it removes it with its contents.
pub(crate) struct AtomicFolder {
    /// The folder under its temporary name.
    folder: TempDir,
    /// Handle with the lock; `None` on systems that do not open folders.
    _lock: Option<File>,
}

impl AtomicFolder {
    /// Begins the folder that will be `path`; creates the folders above it.
    ///
    /// # Errors
    /// The error of the file system, with the path.
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        let above = folder_of(path);
        std::fs::create_dir_all(above).map_err(|e| error_at(above, e))?;
        for _ in 0..ATTEMPTS {
            let folder = temporary_folder(path)?;
            let Ok(lock) = File::open(folder.path()) else { return Ok(Self { folder, _lock: None }) };
            if lock_new(&lock, folder.path()) {
                return Ok(Self { folder, _lock: Some(lock) });
            }
        }
        Err(error_at(path, io::Error::other("its temporary folder was removed each time it was created")))
    }

    /// Temporary path of the folder.
    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Leaves the folder in place, unlocked.
    #[cfg(test)]
    pub(crate) fn keep(self) -> PathBuf {
        self.folder.keep()
    }
}

/// Removes temporary files and folders in `folder`, not in folders below, that no running program writes: those without a lock. Has no effect
/// on file systems without locks.
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
            // Removed while the lock is held: a program that creates such a file and then locks it finds that it is gone.
            let _ = if kind.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
        }
    }
}

/// Temporary folders of this program or a killed one beside `path`, to be renamed to `path`; without links.
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

/// Whether a name is one of a temporary file or folder.
pub(crate) fn is_temporary_name(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    name.ends_with(SUFFIX) && name.contains(MARK)
}

/// Flushes the entries of a folder to the disk. Systems on which folders cannot be flushed do not need it.
pub(crate) fn sync_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

/// Locks a new temporary file or folder; false if a concurrent [`remove_leftovers`] has removed it before. On file systems without locks it
/// stays unlocked.
fn lock_new(file: &File, path: &Path) -> bool {
    let _ = file.lock();
    path.symlink_metadata().is_ok()
}

/// Creates a folder with a random name beside `path`.
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

/// The folder that contains a path.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Gives a file or folder the permissions `mode` without those of the user's mask, as usual; temporary files are private by default.
#[cfg(unix)]
fn with_usual_permissions<'b, 'n>(builder: &'b mut Builder<'n, 'n>, mode: u32) -> &'b mut Builder<'n, 'n> {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(Permissions::from_mode(mode))
}

/// Keeps the permissions of the system.
#[cfg(not(unix))]
fn with_usual_permissions<'b, 'n>(builder: &'b mut Builder<'n, 'n>, _mode: u32) -> &'b mut Builder<'n, 'n> {
    builder
}

/// Adds the path to an error that does not name it.
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
