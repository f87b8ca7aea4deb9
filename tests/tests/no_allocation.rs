//! A step in steady contact takes no memory from the system. (Plugins have an allocator of their own; their calls are covered
//! by their own tests.)
#![allow(unsafe_code, reason = "a counting allocator passes every call on")]

use pliant_tests::{box_scene, open};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};

struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: passes every call on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promises are the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are the same.
        unsafe { System.dealloc(ptr, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn steps_in_contact_do_not_allocate() {
    for integrator in ["symplectic-euler", "backward-euler"] {
        let mut session = open(&box_scene(&format!("integrator = \"{integrator}\""), "", ""), 1);
        // Past the approach and the first looks at what has been left behind, into the steady press.
        (0..200).for_each(|_| session.step());
        assert!(session.frame().tools[0].contact.is_some());
        let (before, nodes) = (ALLOCATIONS.load(Ordering::Relaxed), session.frame().nodes);
        (0..50).for_each(|_| session.step());
        let taken = ALLOCATIONS.load(Ordering::Relaxed) - before;
        assert_eq!(session.frame().nodes, nodes, "the region stayed");
        assert_eq!(taken, 0, "{integrator}: {taken} allocations in 50 steps");
        // And the count is not blind.
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        session.update_surface();
        std::hint::black_box(vec![1_u8; 100]);
        assert!(ALLOCATIONS.load(Ordering::Relaxed) > before);
    }
}
