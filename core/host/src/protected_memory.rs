//! Memory between guard pages, for the conformance suite.

use std::io;

/// A multiple of the size of a page on every system, bytes.
#[cfg(unix)]
const PAGE: usize = 64 << 10;

/// Maps `size` bytes, rounded up to pages, before and behind which every access ends the process. They stay mapped until the program ends.
///
/// # Errors
/// The error of the system.
#[cfg(unix)]
#[allow(unsafe_code, reason = "maps memory")]
pub fn protected_memory(size: usize) -> io::Result<&'static mut [u8]> {
    use nix::sys::mman::{MapFlags, ProtFlags, mmap_anonymous, mprotect};
    let size = size.max(1).next_multiple_of(PAGE);
    let whole = std::num::NonZeroUsize::new(size + 2 * PAGE).expect("above zero");
    // SAFETY: a new mapping, of which the part between the first and the last page becomes accessible; it is never unmapped and has no other user.
    unsafe {
        let start = mmap_anonymous(None, whole, ProtFlags::PROT_NONE, MapFlags::MAP_PRIVATE)?.byte_add(PAGE);
        mprotect(start, size, ProtFlags::PROT_READ | ProtFlags::PROT_WRITE)?;
        Ok(std::slice::from_raw_parts_mut(start.cast().as_ptr(), size))
    }
}

/// Maps memory: not implemented for this system.
///
/// # Errors
/// Always [`io::ErrorKind::Unsupported`].
#[cfg(not(unix))]
pub fn protected_memory(_size: usize) -> io::Result<&'static mut [u8]> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "memory is protected on Unix alone"))
}
