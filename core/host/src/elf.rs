//! Whether a library's file is all there. The dynamic linker maps what the head of an ELF file promises without looking
//! at how long the file is, and a copy that was cut off then ends the program when its missing part is read.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

const HEAD: usize = 64;
const SEGMENT: usize = 56;
const LOADED: u64 = 1;

/// What is missing of the file at `path`, if something is. Files of another format, and what cannot be read, are left to
/// the dynamic linker.
pub(super) fn missing(path: &Path) -> Option<String> {
    let (needed, length) = extent(path).ok()??;
    (needed > length).then(|| format!("cut off: {length} bytes of at least {needed}"))
}

/// Bytes that the loaded segments of a 64-bit little-endian ELF file need, and bytes that it has.
fn extent(path: &Path) -> io::Result<Option<(u64, u64)>> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    let mut head = [0; HEAD];
    file.read_exact(&mut head)?;
    if head[..6] != *b"\x7fELF\x02\x01" {
        return Ok(None);
    }
    let (table, size, count) = (number(&head[32..40]), number(&head[54..56]), number(&head[56..58]));
    let mut needed = table.saturating_add(size * count);
    if size < SEGMENT as u64 || needed > length {
        return Ok(Some((needed, length)));
    }
    for i in 0..count {
        let mut segment = [0; SEGMENT];
        file.seek(SeekFrom::Start(table + i * size))?;
        file.read_exact(&mut segment)?;
        if number(&segment[..4]) == LOADED {
            needed = needed.max(number(&segment[8..16]).saturating_add(number(&segment[32..40])));
        }
    }
    Ok(Some((needed, length)))
}

fn number(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b))
}
