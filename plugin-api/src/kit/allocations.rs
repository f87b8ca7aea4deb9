//! Counting what a test takes from the system's memory.
#![allow(unsafe_code, reason = "an allocator passes every call on")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};

/// The system's allocator, counting calls: `#[global_allocator] static A: CountingAllocator = CountingAllocator;` in a test.
/// It sees a plugin that is linked into the test, and not one in a shared library: that has an allocator of its own.
pub struct CountingAllocator;

static INSTALLED: AtomicBool = AtomicBool::new(false);

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    INSTALLED.store(true, Ordering::Relaxed);
    let _ = COUNT.try_with(|c| c.set(c.get() + 1));
}

// SAFETY: passes every call on to the system's allocator.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promises are the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are the same.
        unsafe { System.dealloc(ptr, layout) }
    }

    unsafe fn realloc(&self, ptr: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's promises are the same.
        unsafe { System.realloc(ptr, layout, size) }
    }
}

/// Allocations of this thread so far; `None` without a [`CountingAllocator`].
pub fn allocations() -> Option<u64> {
    std::hint::black_box(Vec::<u8>::with_capacity(1));
    INSTALLED.load(Ordering::Relaxed).then(|| COUNT.with(Cell::get))
}
