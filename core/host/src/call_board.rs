//! The calls of a process, shared with the process that watches it.

use crate::calls::{Board, PluginCall, use_board};
use std::fs::File;
use std::io;
use std::path::Path;

/// The calls of another process, which was started with the path of the board's file and has called [`share_calls`] with it.
pub struct CallBoard {
    board: &'static Board,
}

impl CallBoard {
    /// An empty board in a file, which is made as large as a board. The mapping stays until the program ends.
    ///
    /// # Errors
    /// What the system says; a system without shared mappings.
    pub fn new(file: &File) -> io::Result<Self> {
        file.set_len(size_of::<Board>() as u64)?;
        Ok(Self { board: map(file)? })
    }

    /// Every call that a thread of the other process is in.
    pub fn calls(&self) -> Vec<PluginCall> {
        self.board.calls()
    }

    /// The exit code with which the other process has ended by itself; `None` if it has not. What ends it from inside of a plugin
    /// does not set this.
    pub fn ended(&self) -> Option<u8> {
        self.board.ended()
    }
}

/// Notes the calls of this process on the board in a file. To be called before the first plugin is opened.
///
/// # Errors
/// What the system says, or a file that is not as large as a board.
pub fn share_calls(path: &Path) -> io::Result<()> {
    let file = File::options().read(true).write(true).open(path)?;
    if file.metadata()?.len() != size_of::<Board>() as u64 {
        return Err(io::Error::other(format!("{}: not a board of plugin calls of this version", path.display())));
    }
    use_board(map(&file)?);
    Ok(())
}

/// Maps a board for good.
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
        assert_eq!((reader.ended(), reader.calls()), (None, vec![]));
        writer.end(3);
        assert_eq!(reader.ended(), Some(3));
        file.set_len(1).expect("shorter");
        assert!(share_calls(&path).is_err());
        std::fs::remove_file(&path).expect("removed");
    }
}
