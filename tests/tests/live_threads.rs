//! The threads of a live session: nothing of the haptic one takes memory, and every way out stops the devices.
#![allow(unsafe_code, reason = "a counting allocator passes every call on")]

use pliant_engine::session::{EventKind, Session};
use pliant_host::{DeviceInfo, EffectorOutput, Pose};
use pliant_live::{
    HapticDevice, LiveSession, LiveSettings, PointerDevice, StopDevice, ViewFrame, Viewer, ViewerThread, view_buffer,
};
use pliant_mesh::geometry::Vec3;
use pliant_plugin_api::abi::{POSE_VALID, Status};
use pliant_tests::{Bench, box_scene, open};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

struct Counting;

thread_local! {
    static TAKEN: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: passes every call on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = TAKEN.try_with(|taken| taken.set(taken.get() + 1));
        // SAFETY: the caller's promises are the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        let _ = TAKEN.try_with(|taken| taken.set(taken.get() + 1));
        // SAFETY: the caller's promises are the same.
        unsafe { System.dealloc(ptr, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// What a device does besides being one.
#[derive(Clone, Copy, PartialEq)]
enum Quirk {
    None,
    Allocates,
    Panics,
    Hangs,
    Unplugged,
}

/// What a test sees of it.
#[derive(Default)]
struct Seen {
    ticks: AtomicU64,
    /// Allocations on its thread from its second read on.
    taken: AtomicU64,
    stopped: AtomicBool,
    /// Whether the last force was other than zero.
    pushes: AtomicBool,
}

/// Presses 3 mm in, and counts what its thread takes between reads.
struct Watching {
    facts: DeviceInfo,
    quirk: Quirk,
    seen: Arc<Seen>,
    before: Option<u64>,
}

impl HapticDevice for Watching {
    fn device_info(&self) -> DeviceInfo {
        self.facts
    }

    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        let now = TAKEN.with(Cell::get);
        if let Some(before) = self.before {
            self.seen.taken.fetch_add(now - before, Ordering::Relaxed);
        }
        let tick = self.seen.ticks.fetch_add(1, Ordering::Relaxed);
        match self.quirk {
            Quirk::Allocates => drop(std::hint::black_box(vec![0_u8; 64])),
            Quirk::Panics if tick == 50 => panic!("on purpose, on the haptic thread"),
            Quirk::Hangs if tick == 50 => std::thread::sleep(Duration::from_millis(300)),
            Quirk::Unplugged if tick == 50 => return Status::IO,
            Quirk::None | Quirk::Panics | Quirk::Hangs | Quirk::Unplugged => {}
        }
        let height = (0.006 - 1e-4 * tick as f64).max(0.001);
        poses.fill(Pose { time_ns: time, flags: POSE_VALID, position: [0.0, 0.0, height], ..Pose::default() });
        self.before = Some(now);
        Status::OK
    }

    fn write(&mut self, _: u64, outputs: &[EffectorOutput<'_>]) -> Status {
        self.seen.pushes.store(outputs[0].force != [0.0; 3], Ordering::Relaxed);
        Status::OK
    }

    fn stop_handle(&self) -> StopDevice {
        let seen = Arc::clone(&self.seen);
        Box::new(move || {
            seen.stopped.store(true, Ordering::Relaxed);
            seen.pushes.store(false, Ordering::Relaxed);
        })
    }
}

/// A block under a device with a quirk.
fn start(quirk: Quirk) -> (Session, LiveSession, Arc<Seen>) {
    let session = open(&box_scene("", "", ""), 1);
    begin(session, quirk, LiveSettings::default())
}

fn begin(mut session: Session, quirk: Quirk, settings: LiveSettings) -> (Session, LiveSession, Arc<Seen>) {
    let facts = session.devices[0].facts;
    drop(session.take_devices());
    let seen = Arc::new(Seen::default());
    let device = Watching { facts, quirk, seen: Arc::clone(&seen), before: None };
    let live = LiveSession::start_with_devices(&mut session, vec![Box::new(device)], settings).expect("threads");
    (session, live, seen)
}

/// Steps until a number of ticks was done.
fn until(ticks: u64, session: &mut Session, live: &mut LiveSession, seen: &Seen) {
    while seen.ticks.load(Ordering::Relaxed) < ticks {
        live.step(session);
    }
}

#[test]
fn the_haptic_thread_takes_no_memory() {
    let (mut session, mut live, seen) = start(Quirk::None);
    until(300, &mut session, &mut live, &seen);
    // However slow the simulation is here: until the hand feels it, and on.
    while !seen.pushes.load(Ordering::Relaxed) {
        live.step(&mut session);
    }
    let ticks = seen.ticks.load(Ordering::Relaxed);
    until(ticks + 100, &mut session, &mut live, &seen);
    let summary = live.finish();
    assert!(summary.ticks >= 300 && summary.contact_age.is_some() && !summary.panicked, "{summary:?}");
    assert_eq!(seen.taken.load(Ordering::Relaxed), 0, "allocations and releases in {} ticks", summary.ticks);
    assert!(seen.stopped.load(Ordering::Relaxed) && !seen.pushes.load(Ordering::Relaxed), "an orderly end");
    // And the count is not blind.
    let (mut session, mut live, seen) = start(Quirk::Allocates);
    until(100, &mut session, &mut live, &seen);
    drop(live);
    assert!(seen.taken.load(Ordering::Relaxed) >= 100);
}

#[test]
fn a_panic_of_the_simulation_stops_the_devices() {
    let (mut session, mut live, seen) = start(Quirk::None);
    until(200, &mut session, &mut live, &seen);
    assert!(!seen.stopped.load(Ordering::Relaxed));
    let gone = std::thread::spawn(move || {
        let _live = live;
        panic!("on purpose, in the simulation");
    });
    assert!(gone.join().is_err() && seen.stopped.load(Ordering::Relaxed) && !seen.pushes.load(Ordering::Relaxed));
}

#[test]
fn a_panic_of_the_haptic_thread_stops_the_devices_and_is_told() {
    let (mut session, mut live, seen) = start(Quirk::Panics);
    while live.is_alive() {
        live.step(&mut session);
    }
    assert!(seen.stopped.load(Ordering::Relaxed) && !seen.pushes.load(Ordering::Relaxed));
    let summary = live.finish();
    assert!(summary.panicked && summary.ticks == 50, "{summary:?}");
}

#[test]
fn the_watchdog_stops_a_device_whose_driver_hangs() {
    let (mut session, mut live, seen) = start(Quirk::Hangs);
    until(60, &mut session, &mut live, &seen);
    assert!(seen.stopped.load(Ordering::Relaxed), "while its driver hung");
    let summary = live.finish();
    assert!(summary.watchdog_trips >= 1 && summary.missed > 100, "{summary:?}");
}

#[test]
fn a_device_that_is_unplugged_is_told_and_the_session_goes_on() {
    let (mut session, mut live, seen) = start(Quirk::Unplugged);
    while session.steps() < 200 || session.events.count(EventKind::DeviceLost) == 0 {
        live.step(&mut session);
    }
    let told = session.events.described().iter().find(|(kind, _)| *kind == EventKind::DeviceLost).expect("told");
    assert!(told.1.text.contains("`hand`") && told.1.text.contains("read"), "{}", told.1.text);
    assert_eq!(seen.ticks.load(Ordering::Relaxed), 51, "not read again");
    assert!(live.is_alive() && session.events.count(EventKind::DeviceLost) == 1);
}

/// Counts pictures, slowly.
struct Slow(Arc<AtomicU64>, Arc<AtomicU64>);

impl Viewer for Slow {
    fn show(&mut self, picture: &ViewFrame) {
        let moved = picture.bodies[0].positions.len() > 100 && picture.tools.len() == 1;
        self.0.fetch_add(u64::from(moved), Ordering::Relaxed);
        let rising = self.1.swap(picture.time.to_bits(), Ordering::Relaxed) < picture.time.to_bits();
        assert!(rising, "an old picture at {} s", picture.time);
        std::thread::sleep(Duration::from_millis(40));
    }
}

#[test]
fn a_viewer_sees_whole_pictures_and_holds_nobody_up() {
    let (shown, last) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicU64::new(0)));
    let viewer = Slow(Arc::clone(&shown), Arc::clone(&last));
    let session = open(&box_scene("", "", ""), 1);
    let (writer, reader) = view_buffer(&session);
    let _thread = ViewerThread::start(reader, Box::new(viewer)).expect("a thread");
    let (mut session, mut live, _) = begin(session, Quirk::None, LiveSettings { rate: None, view: Some(writer) });
    while shown.load(Ordering::Relaxed) < 3 {
        live.step(&mut session);
    }
    let summary = live.finish();
    assert!(!summary.panicked && session.steps() > 3, "{summary:?}");
}

#[test]
fn a_pointer_is_a_hand() {
    let mut session = open(&box_scene("", "", ""), 1);
    let (pointer, mut hand) = PointerDevice::new(session.devices[0].facts);
    drop(session.take_devices());
    let mut live = LiveSession::start_with_devices(&mut session, vec![Box::new(pointer)], LiveSettings::default())
        .expect("threads");
    live.step(&mut session);
    assert!(!session.tools[0].hand.present, "nobody has pointed yet");
    for step in 0..300 {
        hand.move_to(Vec3::new(0.0, 0.0, (0.006 - 1e-4 * f64::from(step)).max(0.001)), 0);
        live.step(&mut session);
    }
    while hand.force() == Vec3::zeros() {
        live.step(&mut session);
    }
    assert!(hand.force()[2] > 0.0, "pushed back out: {:?}", hand.force());
    hand.remove();
    while session.tools[0].hand.present {
        live.step(&mut session);
    }
}

#[test]
fn the_program_runs_live_and_its_recording_is_the_same_offline() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    let run = ["run", "scene.toml", "--live", "--duration", "400 ms", "--out", "live", "--record", "hand.rec"];
    let ran = bench.pliant(&run).expect(0);
    ran.says(&["ticks at 1000 Hz", "device to force", "of real time", "priority"]);
    let live = &bench.summary("live")["live"];
    assert!(live["ticks"].as_u64() > Some(10) && live["period"]["p999"].as_f64() > Some(0.0), "{live}");
    bench.pliant(&["replay", "hand.rec", "--verify", "--out", "again"]).expect(0).says(&["to the bit"]);
    assert_eq!(bench.read("live/final.obj"), bench.read("again/final.obj"));
    assert_eq!(bench.read("live/nodes.csv"), bench.read("again/nodes.csv"));
}

#[test]
fn ctrl_c_ends_a_live_run_in_order() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    let mut command = bench.command(&["run", "scene.toml", "--live", "--duration", "600 s", "-q", "--out", "out"]);
    let mut child = command.spawn().expect("started");
    bench.wait_for_rows(&mut child, &[]);
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(kill.success());
    assert_eq!(child.wait().expect("ended").code(), Some(130));
    let live = bench.summary("out/interrupted")["live"].clone();
    assert!(live["panicked"] == false, "{live}");
}

#[test]
fn what_cannot_be_live_is_refused() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    for (args, says) in [
        (vec!["run", "scene.toml", "--duration", "1 s"], "--live"),
        (vec!["run", "scene.toml", "--live", "--duration=-1 s"], "above 0"),
        (vec!["run", "scene.toml", "--live", "--rate", "40 kHz"], "100 Hz to 4 kHz"),
        (vec!["run", "scene.toml", "--live", "--set", "edit.0.start=99"], "no device is open"),
    ] {
        bench.pliant(&args).expect(2).says(&[says]);
    }
}
