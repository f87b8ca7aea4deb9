//! Detection of truncated library files. The dynamic linker maps the segments that the header of an ELF file declares without comparing them
//! with the length of the file, and the program is killed when it reads a missing part.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes of the header of a 64-bit ELF file.
const HEADER: usize = 64;
/// Bytes of an entry of its program header table.
const PROGRAM_HEADER: usize = 56;
/// Type of a segment that is mapped (`PT_LOAD`).
const PT_LOAD: u64 = 1;

/// A message if the file at `path` is truncated. Files of another format and unreadable files are left to the dynamic linker.
pub(crate) fn truncation(path: &Path) -> Option<String> {
    let Extent { needed, length } = extent(path).ok()??;
    (needed > length).then(|| format!("the file is cut off: it has {length} bytes and needs at least {needed}"))
}

/// Sizes of an ELF file, bytes.
struct Extent {
    /// End of the last mapped segment.
    needed: u64,
    /// Length of the file.
    length: u64,
}

/// Sizes of a 64-bit little-endian ELF file; `None` for other files.
fn extent(path: &Path) -> io::Result<Option<Extent>> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    let mut head = [0; HEADER];
    file.read_exact(&mut head)?;
    if head[..6] != *b"\x7fELF\x02\x01" {
        return Ok(None);
    }
    let (table, size, count) = (number(&head[32..40]), number(&head[54..56]), number(&head[56..58]));
    let mut needed = table.saturating_add(size * count);
    if size < PROGRAM_HEADER as u64 || needed > length {
        return Ok(Some(Extent { needed, length }));
    }
    for i in 0..count {
        let mut segment = [0; PROGRAM_HEADER];
        file.seek(SeekFrom::Start(table + i * size))?;
        file.read_exact(&mut segment)?;
        if number(&segment[..4]) == PT_LOAD {
            needed = needed.max(number(&segment[8..16]).saturating_add(number(&segment[32..40])));
        }
    }
    Ok(Some(Extent { needed, length }))
}

/// A little-endian number of up to 8 bytes.
fn number(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b))
}
