//! Software prefetch.

/// Prefetches the cache line in which `list[index]` begins, without waiting for it. An index past the end is allowed.
///
/// Hardware prefetchers follow a stream within a page (4 KiB) but stop at its end, so a kernel that streams through large arrays
/// prefetches half a page to two pages ahead.
#[inline(always)]
#[allow(unsafe_code, reason = "a prefetch instruction reads nothing")]
pub fn prefetch<T>(list: &[T], index: usize) {
    let address = list.as_ptr().wrapping_add(index);
    #[cfg(target_arch = "x86_64")]
    // SAFETY: the instruction is a hint that takes any address: it reads nothing and cannot fault. Every x86-64 processor has it.
    unsafe {
        core::arch::x86_64::_mm_prefetch::<{ core::arch::x86_64::_MM_HINT_T0 }>(address.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = address;
}
