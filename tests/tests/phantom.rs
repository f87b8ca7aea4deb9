//! The phantom plugin against a stand-in for the driver library, with a simulated arm behind it: the code that would drive the
//! hardware runs as it is. The stand-in is one for the process, so the tests take turns.
#![allow(unsafe_code, reason = "calls the stand-in from behind")]

use libloading::{Library, Symbol};
use pliant_mesh::testing::scan;
use pliant_phantom::Phantom;
use pliant_phantom::errors::{CODES, Class};
use pliant_plugin_api::abi::{Output, Pose};
use pliant_plugin_api::param::{self, Params, Value};
use pliant_plugin_api::{Device, Fault};
use pliant_tests::{Bench, built, root, shared_mesh, twin::CASES_OF_A_DEVICE};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

static TURN: Mutex<()> = Mutex::new(());
/// ns
const MS: u64 = 1_000_000;

/// The stand-in, from behind.
struct Stub {
    library: Library,
    _turn: MutexGuard<'static, ()>,
}

/// What is true of an arm.
#[derive(Clone, Copy, Debug)]
struct Look {
    tip: [f64; 3],
    force: [f64; 3],
    pull: [f64; 3],
    on: bool,
    broken: f64,
}

macro_rules! behind {
    ($stub:ident, $name:literal $(, $arg:expr => $type:ty)*) => {{
        // SAFETY: the stand-in has a function of that name with these arguments.
        unsafe {
            let call: Symbol<'_, unsafe extern "C" fn($($type),*)> = $stub.library.get($name).expect("exported");
            call($($arg),*)
        }
    }};
}

impl Stub {
    fn new() -> Self {
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: ours, built beside this test.
        let library = unsafe { Library::new(built("libHD.so")) }.expect("the stand-in");
        let stub = Self { library, _turn: turn };
        behind!(stub, b"pliant_stub_reset\0");
        stub
    }

    fn look(&self, arm: u32) -> Look {
        let mut n = [0.0; 11];
        behind!(self, b"pliant_stub_look\0", arm => u32, n.as_mut_ptr() => *mut f64);
        let v = |i: usize| [n[i], n[i + 1], n[i + 2]];
        Look { tip: v(0), force: v(3), pull: v(6), on: n[9] == 1.0, broken: n[10] }
    }

    fn hand(&self, arm: u32, at: [f64; 3], stiffness: f64) {
        behind!(self, b"pliant_stub_hand\0", arm => u32, at[0] => f64, at[1] => f64, at[2] => f64, stiffness => f64);
    }

    fn inject(&self, code: u32) {
        behind!(self, b"pliant_stub_inject\0", code => u32);
    }
}

fn open(with: &[(&str, Value)]) -> Result<Phantom, Fault> {
    let declared = Phantom::INFO.params;
    let mut values = param::defaults(declared);
    let library = built("libHD.so").to_str().unwrap().to_owned();
    values[param::position(declared, "library").unwrap()] = Value::Text(library);
    for (key, value) in with {
        values[param::position(declared, key).unwrap()] = value.clone();
    }
    Phantom::new(&Params::new(declared, &values))
}

fn output(force: [f64; 3], valid_until_ns: u64) -> Output {
    Output { size: size_of::<Output>(), force, torque: [0.0; 3], taxels: std::ptr::null(), valid_until_ns }
}

/// A host that reads and writes every millisecond.
struct Host<'a> {
    device: &'a Phantom,
    start: Instant,
    poses: [Pose; 2],
}

impl<'a> Host<'a> {
    fn new(device: &'a Phantom) -> Self {
        Self { device, start: Instant::now(), poses: [Pose::default(); 2] }
    }

    fn now(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    fn tick(&mut self, force: [f64; 3]) -> Result<(), Fault> {
        let (now, arms) = (self.now(), self.device.describe().effectors as usize);
        self.device.read(now, &mut self.poses[..arms])?;
        self.device.write(now, &[output(force, now + 50 * MS); 2][..arms])?;
        std::thread::sleep(Duration::from_millis(1));
        Ok(())
    }

    /// Ticks until something is so.
    fn until(&mut self, force: [f64; 3], what: &str, so: impl Fn(&Self) -> bool) {
        let begun = Instant::now();
        while !so(self) {
            self.tick(force).unwrap_or_else(|e| panic!("{what}: {e}"));
            assert!(begun.elapsed() < Duration::from_secs(20), "{what} never comes");
        }
    }

    fn is_valid(&self, arm: usize) -> bool {
        self.poses[arm].flags & 1 == 1
    }

    fn count(&self, name: &str) -> u64 {
        let all = (0..).map_while(|i| self.device.counter(i));
        all.into_iter().find(|(n, _)| n.to_str() == Ok(name)).unwrap_or_else(|| panic!("{name}")).1
    }
}

fn size(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

#[test]
fn an_arm_is_read_and_its_force_arrives_at_the_hand() {
    let stub = Stub::new();
    let device = open(&[]).unwrap_or_else(|e| panic!("{e}"));
    let facts = device.describe();
    assert_eq!((facts.peak_force, facts.continuous_force, facts.stiffness, facts.rate), (3.3, 0.88, 500.0, 1000.0));
    assert_eq!(facts.workspace, [-0.08, -0.06, -0.035, 0.08, 0.06, 0.035]);
    let mut host = Host::new(&device);
    stub.hand(0, [0.02, 0.0, 0.01], 300.0);
    let force = [0.0, 0.8, 0.0];
    host.until(force, "rest", |h| {
        let look = stub.look(0);
        h.is_valid(0) && (look.pull[1] + 0.8).abs() < 0.3 && (look.tip[0] - 0.02).abs() < 2e-3 && h.now() > 1_500 * MS
    });
    let (look, pose) = (stub.look(0), host.poses[0]);
    let off: f64 = (0..3).map(|c| (pose.position[c] - look.tip[c]).abs()).fold(0.0, f64::max);
    println!("{look:?}\npose off by {off:e} m");
    assert!(off < 5e-4 && look.on && size(look.force) <= 3.3);
    assert!((pose.orientation.iter().map(|q| q * q).sum::<f64>() - 1.0).abs() < 1e-9);
    // Whatever is asked, not more than the peak; and a stop is at once.
    host.until([300.0, 0.0, 0.0], "the peak", |_| (size(stub.look(0).force) - 3.3).abs() < 1e-9);
    device.stop();
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(stub.look(0).force, [0.0; 3]);
    // Every frame was begun and ended, and nothing was set or switched where it may not be.
    assert_eq!(stub.look(0).broken, 0.0);
}

#[test]
fn a_host_that_falls_silent_leaves_no_force() {
    let stub = Stub::new();
    let device = open(&[]).unwrap_or_else(|e| panic!("{e}"));
    let mut host = Host::new(&device);
    host.until([1.0, 0.0, 0.0], "force", |_| size(stub.look(0).force) > 0.9);
    let last = Instant::now();
    while size(stub.look(0).force) > 0.0 {
        assert!(last.elapsed() < Duration::from_secs(5), "never ends");
        std::thread::sleep(Duration::from_micros(200));
    }
    println!("zero {:.1} ms after the last write, which held for 50 ms", last.elapsed().as_secs_f64() * 1e3);
}

#[test]
fn every_error_is_met_as_its_class_asks() {
    let stub = Stub::new();
    let device = open(&[]).unwrap_or_else(|e| panic!("{e}"));
    let mut host = Host::new(&device);
    let force = [0.5, 0.0, 0.0];
    for (code, name, class) in CODES.iter().copied().chain([(0x0777, "unknown", Class::Unknown)]) {
        host.until(force, name, |h| h.is_valid(0) && size(stub.look(0).force) > 0.4);
        let before = ["force errors", "losses", "usage and frame errors", "recoveries"].map(|c| host.count(c));
        stub.inject(code);
        // The counters follow the code.
        let counted =
            |h: &Host| ["force errors", "losses", "usage and frame errors"].map(|c| h.count(c)).iter().sum::<u64>();
        let known: u64 = before[..3].iter().sum();
        host.until(force, name, |h| h.count("newest error") == u64::from(code) && counted(h) > known);
        let after = || ["force errors", "losses", "usage and frame errors", "recoveries"].map(|c| host.count(c));
        match class {
            Class::Force => {
                assert_eq!(after()[0], before[0] + 1, "{name}");
                host.until(force, name, |_| size(stub.look(0).force) == 0.0 && !stub.look(0).on);
                // Back on, slowly.
                host.until(force, name, |_| stub.look(0).on);
                host.until(force, name, |_| size(stub.look(0).force) > 0.49);
            }
            Class::Lost | Class::Unknown | Class::Licence => {
                assert_eq!(after()[1], before[1] + 1, "{name}");
                host.until(force, name, |h| h.count("recoveries") > before[3]);
            }
            Class::Usage | Class::Frame | Class::Scheduler => assert_eq!(after()[2], before[2] + 1, "{name}"),
        }
    }
    assert_eq!(stub.look(0).broken, 0.0);
    println!("{} codes", CODES.len() + 1);
}

#[test]
fn an_arm_that_is_unplugged_is_lost_and_found_again() {
    let stub = Stub::new();
    let device = open(&[]).unwrap_or_else(|e| panic!("{e}"));
    let mut host = Host::new(&device);
    host.until([1.0, 0.0, 0.0], "force", |h| h.is_valid(0) && size(stub.look(0).force) > 0.9);
    behind!(stub, b"pliant_stub_plug\0", 0 => u8);
    host.until([1.0, 0.0, 0.0], "the loss", |h| !h.is_valid(0));
    assert!(size(stub.look(0).force) == 0.0 || stub.look(0).force[0].is_nan());
    behind!(stub, b"pliant_stub_plug\0", 1 => u8);
    host.until([1.0, 0.0, 0.0], "the arm", |h| h.is_valid(0) && size(stub.look(0).force) > 0.9);
    assert!(host.count("recoveries") >= 1);
    // For good, if it stays away.
    let patient = device;
    drop(patient);
    let device = open(&[("lost-after", Value::Number(0.3))]).unwrap_or_else(|e| panic!("{e}"));
    let mut host = Host::new(&device);
    host.until([0.0; 3], "a pose", |h| h.is_valid(0));
    behind!(stub, b"pliant_stub_plug\0", 0 => u8);
    let begun = Instant::now();
    let fault = loop {
        if let Err(fault) = host.tick([0.0; 3]) {
            break fault;
        }
        assert!(begun.elapsed() < Duration::from_secs(10), "it is never told");
    };
    assert!(fault.reason.contains("without a pose"), "{fault}");
}

#[test]
fn a_servo_loop_that_stalls_gives_no_pose_and_goes_on() {
    let stub = Stub::new();
    let device = open(&[]).unwrap_or_else(|e| panic!("{e}"));
    let mut host = Host::new(&device);
    host.until([0.0; 3], "a pose", |h| h.is_valid(0));
    behind!(stub, b"pliant_stub_stall\0", 400 => u64);
    host.until([0.5, 0.0, 0.0], "the stall", |h| !h.is_valid(0));
    assert!(host.count("reads without a pose") > 0);
    host.until([0.5, 0.0, 0.0], "the end of it", |h| h.is_valid(0));
}

#[test]
fn two_arms_are_told_apart() {
    let stub = Stub::new();
    let arms = [("arm", Value::Text("left".into())), ("second-arm", Value::Text("right".into()))];
    let device = open(&arms).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(device.describe().effectors, 2);
    stub.hand(0, [-0.03, 0.0, 0.0], 300.0);
    stub.hand(1, [0.03, 0.0, 0.0], 300.0);
    let mut host = Host::new(&device);
    host.until([0.0; 3], "both", |h| {
        (h.poses[0].position[0] + 0.03).abs() < 2e-3 && (h.poses[1].position[0] - 0.03).abs() < 2e-3
    });
    behind!(stub, b"pliant_stub_stylus\0", 1 => u32, 1 => i32, 0 => u8);
    host.until([0.0; 3], "a button", |h| h.poses[1].buttons == 1 && h.poses[0].buttons == 0);
    // In its inkwell an arm rests.
    behind!(stub, b"pliant_stub_stylus\0", 0 => u32, 0 => i32, 1 => u8);
    host.until([1.0, 0.0, 0.0], "rest", |h| {
        !h.is_valid(0) && size(stub.look(0).force) == 0.0 && size(stub.look(1).force) > 0.9
    });
    let again = open(&[]).err().expect("one driver has one scheduler");
    assert!(again.reason.contains("in use"), "{again}");
    assert_eq!(stub.look(0).broken, 0.0);
}

#[test]
fn calibration_is_brought_up_to_date_or_asked_for() {
    let stub = Stub::new();
    behind!(stub, b"pliant_stub_calibration\0", 0x5001 => u32, 2 => i32);
    drop(open(&[]).unwrap_or_else(|e| panic!("{e}")));
    behind!(stub, b"pliant_stub_calibration\0", 0x5002 => u32, 4 => i32);
    let fault = open(&[("patience", Value::Number(0.1))]).err().expect("not calibrated");
    assert!(fault.reason.contains("inkwell"), "{fault}");
    behind!(stub, b"pliant_stub_calibration\0", 0x5002 => u32, 1 => i32);
    let fault = open(&[("patience", Value::Number(0.1))]).err().expect("not calibrated");
    assert!(fault.reason.contains("vendor's calibration"), "{fault}");
    behind!(stub, b"pliant_stub_calibration\0", 0x5000 => u32, 2 => i32);
    drop(open(&[]).unwrap_or_else(|e| panic!("after refusals it opens: {e}")));
}

#[test]
fn what_is_missing_is_told_with_what_to_do() {
    let stub = Stub::new();
    let fault = open(&[("library", Value::Text("/nowhere/libHD.so".into()))]).err().expect("no library");
    assert!(fault.reason.contains("/nowhere/libHD.so"), "{fault}");
    let fault = open(&[("arm", Value::Text("nobody".into()))]).err().expect("no such arm");
    assert!(fault.reason.contains("`nobody`") && fault.reason.contains("HD_INVALID_VALUE"), "{fault}");
    behind!(stub, b"pliant_stub_plug\0", 0 => u8);
    let fault = open(&[]).err().expect("unplugged");
    assert!(fault.reason.contains("HD_COMM_ERROR") && fault.reason.contains("cable"), "{fault}");
    behind!(stub, b"pliant_stub_plug\0", 1 => u8);
    behind!(stub, b"pliant_stub_refuse\0", 0x0501 => u32);
    let fault = open(&[]).err().expect("full");
    assert!(fault.reason.contains("HD_SCHEDULER_FULL"), "{fault}");
    behind!(stub, b"pliant_stub_refuse\0", 0 => u32);
    // A rate the driver does not have is not the end: what it has is told.
    let device = open(&[("rate", Value::Number(1234.0))]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(device.describe().rate, 1000.0);
}

#[test]
fn the_driver_reads_its_numbers_with_a_point() {
    unsafe extern "C" {
        fn setlocale(category: i32, locale: *const std::ffi::c_char) -> *const std::ffi::c_char;
    }
    let stub = Stub::new();
    // SAFETY: C strings; the tests take turns.
    let set = |name: &std::ffi::CStr| unsafe { setlocale(1, name.as_ptr()) };
    assert!(!set(c"C.UTF-8").is_null(), "a locale every system has");
    drop(open(&[]).unwrap_or_else(|e| panic!("the stand-in takes no other locale than C: {e}")));
    // SAFETY: asking gives a C string.
    let after = unsafe { std::ffi::CStr::from_ptr(setlocale(1, std::ptr::null())) };
    assert_eq!(after.to_str().unwrap(), "C.UTF-8", "given back");
    set(c"C");
    drop(stub);
}

#[test]
fn the_scene_is_touched_through_the_stand_in() {
    let stub = Stub::new();
    drop(stub);
    let bench = Bench::new();
    let scene = root().join("scenes/phantom-touch.toml");
    let library = built("libHD.so");
    let set = format!("device.0.params.library=\"{}\"", library.display());
    bench.pliant(&["run", scene.to_str().unwrap(), "-q", "--out", "out", "--set", &set]).expect(0);
    let summary = bench.summary("out");
    assert!(summary["event_counts"].get("device-lost").is_none(), "{}", summary["events"]);
    let force = summary["probes"][0]["value"].as_f64().unwrap();
    println!("largest force {force} N");
    assert!((0.01..3.3).contains(&force), "{}", summary["probes"]);
    let found =
        bench.pliant(&["device", "doctor", "phantom", "--json", "--set", &format!("library={}", library.display())]);
    let found = found.expect(0).json();
    assert!(found["devices"][0]["findings"][1]["found"].as_str().unwrap().contains("Omni"), "{found}");
    let missing = bench.pliant(&["device", "doctor", "phantom", "--set", "library=/nowhere/libHD.so"]).expect(1);
    assert!(missing.out.contains("missing  driver library") && missing.out.contains("OpenHaptics"), "{}", missing.out);
}

#[test]
fn a_scan_is_touched_live_through_the_stand_in() {
    let bench = Bench::new();
    let mesh = bench.write("scan.obj", scan(0, 20_000, 3, 1).text);
    is_touched_live(&bench, &mesh);
}

#[test]
#[ignore = "needs ../shared/meshes"]
fn the_bunny_is_touched_live_through_the_stand_in() {
    is_touched_live(&Bench::new(), &shared_mesh("stanford-bunny.obj"));
}

fn is_touched_live(bench: &Bench, mesh: &Path) {
    drop(Stub::new());
    let scene = root().join("scenes/phantom-touch.toml");
    let set = format!("device.0.params.library=\"{}\"", built("libHD.so").display());
    let args = ["run", scene.to_str().unwrap(), "--mesh", mesh.to_str().unwrap(), "-q", "--live", "--out", "out"];
    // However slow the simulation is here, the hand comes down every two seconds.
    bench.pliant(&[&args[..], &["--duration", "6 s", "--set", &set]].concat()).expect(0);
    let summary = bench.summary("out");
    let (live, arm) = (&summary["live"], &summary["devices"]["arm"]);
    let force = summary["probes"][0]["value"].as_f64().unwrap();
    assert!((0.01..=3.3).contains(&force), "{}", summary["probes"]);
    assert!(live["contact_age"].is_object() && live["panicked"] == false, "{live}");
    let count = |name: &str| arm[name].as_u64().unwrap_or_else(|| panic!("{name} in {arm}"));
    assert!(count("servo ticks") > 1000, "{arm}");
    assert_eq!(["force errors", "losses", "usage and frame errors", "recoveries"].map(count), [0; 4], "{arm}");
}

#[test]
fn it_keeps_the_promises_of_a_plugin_and_of_a_device() {
    drop(Stub::new());
    let bench = Bench::new();
    let folder = built("libHD.so").parent().unwrap().to_path_buf();
    let plugin = built("libpliant_phantom.so");
    let check = |more: &[&str]| {
        let mut command = bench.command(&[&["plugin", "check", plugin.to_str().unwrap()], more].concat());
        let ran = command.env("LD_LIBRARY_PATH", &folder).output().unwrap();
        let text = String::from_utf8_lossy(&ran.stdout).into_owned();
        assert!(ran.status.success() && text.contains("ok ") && !text.contains("skipped"), "{text}");
        text
    };
    // The whole suite, which opens it more often than there are drivers; and that the list of cases is not empty.
    let text = check(&[]);
    for case in CASES_OF_A_DEVICE.iter().chain(&["opens-many-times", "opens-with-defaults"]) {
        assert!(text.contains(case), "{case} in {text}");
    }
}
