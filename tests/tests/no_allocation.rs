//! A step in steady contact takes no memory from the system. (Plugins have an allocator of their own; their calls are covered
//! by their own tests.)
#![allow(unsafe_code, reason = "a counting allocator passes every call on")]

use pliant_tests::{box_scene, open};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

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

/// An implicit cloth with a fingertip on it.
const CLOTH: &str = r#"
format = 1
gravity = [0, 0, 0]
[time]
duration = 1
integrator = "backward-euler"
[[body]]
shape = { kind = "sheet", cells = 20, rows = 20, pattern = "alternating", size = [0.2, 0.2, 0] }
sheet = { warp = [1, 0, 0] }
material = { plugin = "cloth", params = { damping-time = 1e-2 } }
[[body.fixed]]
box = [[-1, 0.1999, -1], [1, 1, 1]]
[[body.fixed]]
box = [[-1, -1, -1], [1, 0.0001, 1]]
[[device]]
name = "hand"
params = { path = [[0, 0.1, 0.1, 0.009], [0.1, 0.1, 0.1, -0.002]] }
[[tool]]
name = "finger"
device = "hand"
radius = "8 mm"
[[edit]]
kind = "touch"
tool = "finger"
"#;

/// A block that rests on a floor and leans on a ball.
const ON_FLOOR: &str = r#"
format = 1
gravity = [1, 0, -9.81]
[[body]]
shape = { kind = "box", cells = 6, size = [0.06, 0.06, 0.06] }
position = [0, 0, 0.0301]
material = { plugin = "corotational", params = { damping-time = 1e-2 } }
grid = { level = 4, region = "whole" }
[[obstacle]]
name = "floor"
shape = { kind = "plane" }
[[obstacle]]
name = "ball"
shape = { kind = "sphere", radius = 0.02 }
position = [0.0501, 0, 0.02]
"#;

/// Ticks of a loop that rests in between: the other threads of a step have gone to sleep by then.
const PAUSE: Duration = Duration::from_millis(3);

#[test]
fn steps_in_contact_do_not_allocate() {
    let block = |integrator: &str| box_scene(&format!("integrator = \"{integrator}\""), "", "");
    let scenes = [("symplectic-euler", block("symplectic-euler")), ("backward-euler", block("backward-euler"))];
    let normals = CLOTH.replace("damping-time = 1e-2", "damping-time = 1e-2, bending = \"projected-laplacian\"");
    assert_ne!(normals, CLOTH);
    let fine = CLOTH.replace("cells = 20, rows = 20", "cells = 30, rows = 30");
    let one = scenes.into_iter().chain([("cloth", CLOTH.into()), ("cloth, normals", normals)]);
    for (integrator, scene, threads) in
        one.map(|(name, scene)| (name, scene, 1)).chain([("cloth, two threads", fine, 2)])
    {
        let mut session = open(&scene, threads);
        // Past the approach and the first looks at what has been left behind, into the steady press.
        (0..200).for_each(|_| session.step());
        assert!(session.frame().tools[0].contact.is_some());
        let (before, nodes) = (ALLOCATIONS.load(Ordering::Relaxed), session.frame().nodes);
        (0..50).for_each(|_| session.step());
        let taken = ALLOCATIONS.load(Ordering::Relaxed) - before;
        assert_eq!(session.frame().nodes, nodes, "the region stayed");
        assert_eq!(taken, 0, "{integrator}: {taken} allocations in 50 steps");
        if threads > 1 {
            let before = ALLOCATIONS.load(Ordering::Relaxed);
            for _ in 0..20 {
                std::thread::sleep(PAUSE);
                session.step();
            }
            let taken = ALLOCATIONS.load(Ordering::Relaxed) - before;
            assert_eq!(taken, 0, "{integrator}: {taken} allocations in 20 steps with pauses");
            assert_eq!(session.choices.threads, threads);
        }
        // And the count is not blind.
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        session.update_surface();
        std::hint::black_box(vec![1_u8; 100]);
        assert!(ALLOCATIONS.load(Ordering::Relaxed) > before);
    }
    steps_on_obstacles_do_not_allocate();
}

/// Called by the one test, as allocations of another test would be counted.
fn steps_on_obstacles_do_not_allocate() {
    let cloth = CLOTH.replace("gravity = [0, 0, 0]", "gravity = [0, 0, -9.81]");
    let cloth =
        format!("{cloth}[[obstacle]]\nname = \"floor\"\nshape = {{ kind = \"plane\" }}\nposition = [0, 0, -1e-4]\n");
    for scene in [ON_FLOOR.to_owned(), cloth] {
        let mut session = open(&scene, 1);
        (0..300).for_each(|_| session.step());
        assert!(session.obstacles().iter().any(|obstacle| obstacle.force.norm() > 0.0), "nothing is met");
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        (0..50).for_each(|_| session.step());
        let taken = ALLOCATIONS.load(Ordering::Relaxed) - before;
        assert_eq!(taken, 0, "{taken} allocations in 50 steps: {scene}");
    }
}
