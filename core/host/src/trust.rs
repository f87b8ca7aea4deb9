//! Restrictions on the libraries that may be opened, as opening one runs its code.
//!
//! Scenes and recordings may come from others. The plugins they name are searched for in folders of the user's choice; a library that they name
//! by path is opened only in folders that the caller allows. Folders of the environment are searched only if no other user can write to them.

use crate::error::HostError;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Folders from which scenes and recordings may name libraries by path; by default none.
#[derive(Clone, Debug, Default)]
pub struct AllowedFolders {
    /// Absolute paths, links followed.
    folders: Vec<PathBuf>,
}

impl AllowedFolders {
    /// Allows these folders and all folders in them.
    ///
    /// # Errors
    /// [`HostError::AllowedFolder`] for a path that is not a folder.
    pub fn new(folders: &[PathBuf]) -> Result<Self, HostError> {
        let resolve = |folder: &PathBuf| {
            let refuse = |reason: String| HostError::AllowedFolder { folder: folder.clone(), reason };
            let path = folder.canonicalize().map_err(|error| refuse(error.to_string()))?;
            if path.is_dir() { Ok(path) } else { Err(refuse("not a folder".into())) }
        };
        Ok(Self { folders: folders.iter().map(resolve).collect::<Result<_, _>>()? })
    }

    /// Checks that the library at an absolute path, links followed, is in an allowed folder.
    ///
    /// # Errors
    /// [`HostError::NotAllowed`].
    pub fn check(&self, library: &Path) -> Result<(), HostError> {
        if self.folders.iter().any(|folder| library.starts_with(folder)) {
            return Ok(());
        }
        Err(HostError::NotAllowed { path: library.into(), folder: library.parent().unwrap_or(library).into() })
    }

    /// Checks a file whose path is a parameter of a plugin: a library must be in an allowed folder, as the plugin may open it.
    ///
    /// # Errors
    /// [`HostError::NotAllowed`].
    pub fn check_parameter(&self, path: &Path) -> Result<(), HostError> {
        match path.canonicalize() {
            Ok(path) if is_program(&path) => self.check(&path),
            _ => Ok(()),
        }
    }
}

/// Whether a file begins like a shared library or program of any system (ELF, Mach-O, PE), whatever its name.
fn is_program(path: &Path) -> bool {
    const MACH_O: [[u8; 4]; 6] = [
        [0xfe, 0xed, 0xfa, 0xce],
        [0xfe, 0xed, 0xfa, 0xcf],
        [0xce, 0xfa, 0xed, 0xfe],
        [0xcf, 0xfa, 0xed, 0xfe],
        [0xca, 0xfe, 0xba, 0xbe],
        [0xca, 0xfe, 0xba, 0xbf],
    ];
    // A pipe would block; linkers map regular files alone.
    if !path.is_file() {
        return false;
    }
    let mut start = [0; 4];
    let is_read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut start)).is_ok();
    is_read && (start == *b"\x7fELF" || start.starts_with(b"MZ") || MACH_O.contains(&start))
}

/// Reason why users other than this one and the administrator can change a file or folder, directly or through a folder above it; `None` if
/// they cannot, or if it does not exist. In a folder with the sticky bit, such as `/tmp`, others cannot replace files that are not theirs.
///
/// A group whose number is that of the user may write: on systems with a group for each user it has no other members.
#[cfg(unix)]
pub(crate) fn writable_by_others(path: &Path) -> Option<String> {
    use std::os::unix::fs::MetadataExt;
    const STICKY: u32 = 0o1000;
    let path = path.canonicalize().ok()?;
    let user = own_user();
    path.ancestors().find_map(|part| {
        let metadata = part.metadata().ok()?;
        let (owner, group, mode) = (metadata.uid(), metadata.gid(), metadata.mode());
        let part = part.display();
        if owner != 0 && owner != user {
            return Some(format!("{part} belongs to user {owner}"));
        }
        let writable = mode & 0o002 != 0 || (mode & 0o020 != 0 && group != 0 && group != user);
        let protects = mode & STICKY != 0 && *part.to_string() != *path.to_string_lossy();
        (writable && !protects).then(|| format!("other users can write to {part} (mode {:o})", mode & 0o7777))
    })
}

/// Not known on this system.
#[cfg(not(unix))]
pub(crate) fn writable_by_others(_path: &Path) -> Option<String> {
    None
}

/// Number of the user whose rights this process has.
#[cfg(unix)]
#[allow(unsafe_code, reason = "calls the C library")]
fn own_user() -> u32 {
    // SAFETY: has no arguments and cannot fail.
    unsafe { nix::libc::geteuid() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_allowed_by_default_and_folders_with_all_that_is_in_them_are() {
        let folder = std::env::temp_dir().canonicalize().unwrap();
        let library = folder.join("deep/below/evil.so");
        let text = AllowedFolders::default().check(&library).unwrap_err().to_string();
        assert!(text.contains("evil.so") && text.contains("--allow-plugins"), "{text}");
        AllowedFolders::new(&[folder]).unwrap().check(&library).unwrap();
        let absent = AllowedFolders::new(&["/nowhere/at/all".into()]).unwrap_err().to_string();
        assert!(absent.contains("/nowhere/at/all"), "{absent}");
    }

    #[test]
    fn a_program_is_known_by_its_bytes() {
        let own = std::env::current_exe().unwrap();
        assert!(is_program(&own) && AllowedFolders::default().check_parameter(&own).is_err());
        let text = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        assert!(!is_program(&text) && AllowedFolders::default().check_parameter(&text).is_ok());
        assert!(!is_program(Path::new("/")) && !is_program(Path::new("/nowhere")));
    }
}
