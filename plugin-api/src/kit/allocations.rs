//! Counts heap allocations of a test: of the program, and of plugins of any language where a library that counts them is preloaded.
#![allow(unsafe_code, reason = "an allocator that forwards every call, and a function that is looked up by name")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};

/// The system allocator with a count of calls: `#[global_allocator] static A: CountingAllocator = CountingAllocator;` in a test.
///
/// It counts for plugins that are linked into the test; a plugin in a shared library has an allocator of its own.
pub struct CountingAllocator;

/// Whether this allocator is the global one: it has been called.
static INSTALLED: AtomicBool = AtomicBool::new(false);

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
    static LIVE: Cell<i64> = const { Cell::new(0) };
}

/// Counts one allocation of this thread.
fn count() {
    INSTALLED.store(true, Ordering::Relaxed);
    let _ = COUNT.try_with(|c| c.set(c.get() + 1));
}

/// Adds to the allocations of this thread that were not given back.
fn add_live(change: i64) {
    let _ = LIVE.try_with(|live| live.set(live.get() + change));
}

// SAFETY: forwards every call to the system allocator.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        add_live(1);
        // SAFETY: the caller's promises are the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        add_live(-1);
        // SAFETY: the caller's promises are the same.
        unsafe { System.dealloc(ptr, layout) }
    }

    unsafe fn realloc(&self, ptr: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's promises are the same.
        unsafe { System.realloc(ptr, layout, size) }
    }
}

/// Allocations of this thread so far, one of its own included; `None` where [`CountingAllocator`] is not the global allocator.
pub fn allocations() -> Option<u64> {
    std::hint::black_box(Vec::<u8>::with_capacity(1));
    INSTALLED.load(Ordering::Relaxed).then(|| COUNT.with(Cell::get))
}

/// Allocations of this thread so far, as [`CountingAllocator`] has counted them.
pub(super) fn counted() -> u64 {
    COUNT.with(Cell::get)
}

/// Allocations of this thread that were not given back, as [`CountingAllocator`] has counted them.
pub(super) fn live_counted() -> i64 {
    LIVE.with(Cell::get)
}

/// Calls of the allocator of C by this thread so far, where `count-malloc.c` of `pliant plugin new --lang c` is preloaded.
pub(super) fn malloc_calls() -> Option<u64> {
    preloaded(0).map(|count| count() as u64)
}

/// Allocations of C by this thread that were not given back, where the same is preloaded.
pub(super) fn malloc_live() -> Option<i64> {
    preloaded(1).map(|count| count())
}

/// A function of the preloaded library that counts: 0 for its calls, 1 for what is not given back.
#[cfg(target_os = "linux")]
fn preloaded(which: usize) -> Option<extern "C" fn() -> i64> {
    use core::ffi::{CStr, c_char, c_void};
    use std::sync::OnceLock;
    unsafe extern "C" {
        fn dlsym(handle: *mut c_void, symbol: *const c_char) -> *mut c_void;
    }
    const NAMES: [&CStr; 2] = [c"pliant_malloc_calls", c"pliant_malloc_live"];
    static FOUND: [OnceLock<Option<extern "C" fn() -> i64>>; 2] = [const { OnceLock::new() }; 2];
    *FOUND[which].get_or_init(|| {
        // SAFETY: null looks a C string up in all libraries of the program; a library that defines such a name defines this function.
        unsafe {
            let found = dlsym(core::ptr::null_mut(), NAMES[which].as_ptr());
            (!found.is_null()).then(|| core::mem::transmute::<*mut c_void, extern "C" fn() -> i64>(found))
        }
    })
}

/// As on Linux, where libraries can be preloaded; none elsewhere.
#[cfg(not(target_os = "linux"))]
fn preloaded(_: usize) -> Option<extern "C" fn() -> i64> {
    None
}
