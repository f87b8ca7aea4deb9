//! Memory asked for before its turn comes.

/// Asks memory for the line (64 bytes on most processors) in which `list[at]` begins, and does not wait. What is gone through once in
/// a step is then near when its turn comes: a processor does so by itself within a page (4 KiB), but not across its end, so kernels
/// ask for what is half a page to two pages ahead. Past the end of a list it asks for what happens to be there, which does no harm.
#[inline(always)]
#[allow(unsafe_code, reason = "a prefetch reads nothing")]
pub fn prefetch<T>(list: &[T], at: usize) {
    let place = list.as_ptr().wrapping_add(at);
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a hint that takes any address: nothing is read, and nothing faults. Every processor of this architecture has it.
    unsafe {
        core::arch::x86_64::_mm_prefetch::<{ core::arch::x86_64::_MM_HINT_T0 }>(place.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}
