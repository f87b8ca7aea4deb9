//! Memory between guard pages, by which the suite finds what a plugin reads and writes outside of an array even if it changes no result.
//!
//! The system ends the process at such an access. So the caller of the suite provides the memory, in a process of its own, and is told of
//! each call before it is made.
#![allow(unsafe_code, reason = "hands out parts of the memory")]

/// Memory between guard pages.
#[derive(Clone, Copy, Debug)]
pub struct ProtectedMemory {
    start: *mut u8,
    size: usize,
    before_call: fn(&str),
}

/// The end of an array that lies at a guard page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Edge {
    /// The page is before the first value.
    First,
    /// The page is behind the last value.
    Last,
}

impl ProtectedMemory {
    /// Memory before and behind which no access is allowed. `before_call` is told what is called next: the function, its elements, the array at
    /// the page and where the page lies.
    pub fn new(memory: &'static mut [u8], before_call: fn(&str)) -> Self {
        Self { start: memory.as_mut_ptr(), size: memory.len(), before_call }
    }

    /// Says what is called next.
    pub(super) fn announce(&self, call: &str) {
        (self.before_call)(call);
    }

    /// Copies values to the edge of the memory, over what was there. Returns where they are, or `None` if there is no room for them.
    pub(super) fn place<T: Copy>(&self, values: &[T], edge: Edge) -> Option<*mut T> {
        let free = self.size.checked_sub(size_of_val(values))?;
        let at = self.start.wrapping_add(if edge == Edge::First { 0 } else { free }).cast::<T>();
        assert!(at.is_aligned(), "pages are aligned, and sizes are multiples of alignments");
        // SAFETY: `at` and the values behind it are in the memory, which only one array uses at a time.
        unsafe { at.copy_from_nonoverlapping(values.as_ptr(), values.len()) };
        Some(at)
    }
}
