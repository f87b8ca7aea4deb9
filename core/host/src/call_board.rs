//! Call boards in shared memory: a parent process reads which plugin calls its child process is in.

use crate::calls::{Board, PluginCall, use_board};
use std::fs::File;
use std::io;
use std::path::Path;

/// A call board that another process writes: it was started with the path of the board's file and has called [`share_calls`].
pub struct CallBoard {
    /// The mapped board.
    board: &'static Board,
}

impl CallBoard {
    /// Makes a file an empty board and maps it until the program ends.
    ///
    /// # Errors
    /// The error of the system; all systems but Unix, which have no shared mapping here.
    pub fn new(file: &File) -> io::Result<Self> {
        file.set_len(size_of::<Board>() as u64)?;
        Ok(Self { board: map(file)? })
    }

    /// The calls that threads of the other process are in.
    pub fn calls(&self) -> Vec<PluginCall> {
        self.board.calls()
    }

    /// The exit code that the other process has recorded with [`record_exit_code`](crate::record_exit_code); `None` before. A process that a
    /// plugin or a signal ends records none.
    pub fn exit_code(&self) -> Option<u8> {
        self.board.exit_code()
    }
}

/// Uses the board in a file for the calls of this process. Call it before the first plugin is opened.
///
/// # Errors
/// The error of the system, or a file that is not of the size of a board.
pub fn share_calls(path: &Path) -> io::Result<()> {
    let file = File::options().read(true).write(true).open(path)?;
    if file.metadata()?.len() != size_of::<Board>() as u64 {
        return Err(io::Error::other(format!("{}: not a board of plugin calls of this version", path.display())));
    }
    use_board(map(&file)?);
    Ok(())
}

/// Maps a board until the program ends.
#[cfg(unix)]
#[allow(unsafe_code, reason = "maps a file that another process has mapped too")]
fn map(file: &File) -> io::Result<&'static Board> {
    use nix::sys::mman::{MapFlags, ProtFlags, mmap};
    let size = std::num::NonZeroUsize::new(size_of::<Board>()).expect("a board has a size");
    // SAFETY: a new mapping of a file as large as a board, page-aligned; it is never unmapped, every part of a board is atomic, and
    // zeros are a board.
    unsafe {
        let memory = mmap(None, size, ProtFlags::PROT_READ | ProtFlags::PROT_WRITE, MapFlags::MAP_SHARED, file, 0)?;
        Ok(memory.cast::<Board>().as_ref())
    }
}

/// Maps a board: not possible on this system.
#[cfg(not(unix))]
fn map(_: &File) -> io::Result<&'static Board> {
    Err(io::Error::other("this system has no shared mapping of files"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn a_board_is_read_through_another_mapping() {
        let path = std::env::temp_dir().join(format!("pliant-board-{}", std::process::id()));
        let file = File::options().read(true).write(true).create_new(true).open(&path).expect("a file");
        let reader = CallBoard::new(&file).expect("mapped");
        let writer = map(&file).expect("mapped");
        assert_eq!((reader.exit_code(), reader.calls()), (None, vec![]));
        writer.record_exit_code(3);
        assert_eq!(reader.exit_code(), Some(3));
        file.set_len(1).expect("shorter");
        assert!(share_calls(&path).is_err());
        std::fs::remove_file(&path).expect("removed");
    }
}
