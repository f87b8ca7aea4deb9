//! Reading files that others have written: regular files only, and no more bytes than a limit.
//!
//! A pipe would block, a device such as `/dev/zero` never ends, and a file that grows while it is read may not end either.

use std::fs::File;
use std::io::{self, Error, ErrorKind, Read};
use std::path::Path;

/// Bytes, largest text: a scene, a sweep, a catalogue or a table.
pub const TEXT_LIMIT: u64 = 256 << 20;
/// Bytes, largest model.
pub const MODEL_LIMIT: u64 = 4 << 30;
/// Bytes, largest image: one of 8192 x 8192 pixels that no compression made smaller has 256 MiB and a bit.
pub const IMAGE_LIMIT: u64 = 512 << 20;
/// Bytes, largest recording.
pub const RECORDING_LIMIT: u64 = 8 << 30;

/// Opens a regular file; a link to one counts as one.
///
/// # Errors
/// What the file system says, or what the file is instead, without the path.
fn open(path: &Path) -> io::Result<File> {
    // Before it is opened, as opening a pipe waits for its other end.
    require_regular(&path.metadata()?)?;
    let file = File::open(path)?;
    require_regular(&file.metadata()?)?;
    Ok(file)
}

/// Opens a regular file; a link to one counts as one.
///
/// # Errors
/// What the file system says, or what the file is instead, with the path.
pub fn open_regular(path: &Path) -> io::Result<File> {
    open(path).map_err(|error| Error::new(error.kind(), format!("{}: {error}", path.display())))
}

/// The bytes of a regular file of at most `limit` bytes.
///
/// # Errors
/// What the file system says, what the file is instead, or its size and the limit; without the path, as with [`std::fs::read`].
pub fn read_file(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let too_large = |size: u64| {
        Err(Error::new(ErrorKind::FileTooLarge, format!("{size} bytes or more; allowed is at most {limit}")))
    };
    let size = file.metadata()?.len();
    if size > limit {
        return too_large(size);
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(size as usize).map_err(|_| Error::from(ErrorKind::OutOfMemory))?;
    // Its size may not be what the system tells, as in /proc, and it may grow.
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit { too_large(limit + 1) } else { Ok(bytes) }
}

/// The text of a regular file of at most [`TEXT_LIMIT`] bytes.
///
/// # Errors
/// As for [`read_file`], and text that is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let bytes = read_file(path, TEXT_LIMIT)?;
    String::from_utf8(bytes).map_err(|_| Error::new(ErrorKind::InvalidData, "not UTF-8 text"))
}

fn require_regular(metadata: &std::fs::Metadata) -> io::Result<()> {
    if metadata.is_file() {
        return Ok(());
    }
    let kind = kind_name(metadata.file_type());
    Err(Error::new(ErrorKind::InvalidInput, format!("{kind}; allowed is a regular file")))
}

/// What a file is that is not regular.
#[cfg(unix)]
fn kind_name(kind: std::fs::FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match kind {
        kind if kind.is_dir() => "a folder",
        kind if kind.is_fifo() => "a pipe",
        kind if kind.is_socket() => "a socket",
        _ => "a device",
    }
}

/// What a file is that is not regular.
#[cfg(not(unix))]
fn kind_name(kind: std::fs::FileType) -> &'static str {
    if kind.is_dir() { "a folder" } else { "a device" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_over_the_limit_is_refused_with_both_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, [7; 100]).unwrap();
        assert_eq!(read_file(&path, 100).unwrap(), [7; 100]);
        let error = read_file(&path, 99).unwrap_err();
        assert!(error.kind() == ErrorKind::FileTooLarge && error.to_string().contains("100 bytes"), "{error}");
        // A file of a size that no machine has memory for.
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        assert!(read_file(&path, MODEL_LIMIT).unwrap_err().to_string().contains("1099511627776"));
    }

    #[test]
    #[cfg(unix)]
    fn what_is_no_regular_file_is_named() {
        let folder = tempfile::tempdir().unwrap();
        for (path, kind) in [(Path::new("/dev/zero"), "a device"), (folder.path(), "a folder")] {
            assert!(read_file(path, 10).unwrap_err().to_string().contains(kind));
            let text = open_regular(path).unwrap_err().to_string();
            assert!(text.contains(&*path.to_string_lossy()), "{text}");
        }
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        assert!(read_file(&link, 10).unwrap_err().to_string().contains("a device"));
        // A pipe that nobody writes to: to open it would wait for ever.
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        assert!(read_file(&pipe, 10).unwrap_err().to_string().contains("a pipe"));
    }
}
