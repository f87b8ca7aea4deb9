//! The phantom plugin with a replacement of the driver library (`tests/hd-stub`) and a simulated arm behind it: the code that would drive
//! hardware runs unchanged. The library has one state per process, so the tests run one after the other.
#![allow(unsafe_code, reason = "calls functions of the replaced driver library")]

use libloading::{Library, Symbol};
use pliant_mesh::testing::scan;
use pliant_phantom::Phantom;
use pliant_phantom::errors::{ERROR_CODES, ErrorClass, ErrorCode};
use pliant_plugin_api::abi::{Output, POSE_VALID, Pose};
use pliant_plugin_api::param::{self, Params, Value};
use pliant_plugin_api::{Device, Fault};
use pliant_tests::{Bench, built, deps, root, shared_mesh, twin::CASES_OF_A_DEVICE};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Held by the test that uses the driver library.
static DRIVER_IN_USE: Mutex<()> = Mutex::new(());
/// A millisecond in ns.
const MS: u64 = 1_000_000;

/// The replaced driver library, with its functions for tests.
struct Stub {
    library: Library,
    _in_use: MutexGuard<'static, ()>,
}

/// The true state of a simulated arm; NaN if it is not open.
#[derive(Clone, Copy, Debug)]
struct SimulatedArm {
    /// m
    tip: [f64; 3],
    /// Force of the motors, N.
    force: [f64; 3],
    /// Force of the hand on the tip, N.
    hand_force: [f64; 3],
    is_output_on: bool,
    /// Calls of the driver that violated its rules.
    violations: f64,
}

/// Calls a function of the library without a result, from arguments and their C types.
macro_rules! call_stub {
    ($stub:ident, $name:literal $(, $arg:expr => $type:ty)*) => {{
        // SAFETY: the library has a function of that name with these arguments.
        unsafe {
            let function: Symbol<'_, unsafe extern "C" fn($($type),*)> = $stub.library.get($name).expect("exported");
            function($($arg),*)
        }
    }};
}

impl Stub {
    fn new() -> Self {
        let in_use = DRIVER_IN_USE.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: our own library, built beside this test.
        let library = unsafe { Library::new(built("libHD.so")) }.expect("a built driver library");
        let stub = Self { library, _in_use: in_use };
        call_stub!(stub, b"pliant_stub_reset\0");
        stub
    }

    fn arm(&self, handle: u32) -> SimulatedArm {
        let mut n = [0.0; 11];
        call_stub!(self, b"pliant_stub_read_arm\0", handle => u32, n.as_mut_ptr() => *mut f64);
        let v = |i: usize| [n[i], n[i + 1], n[i + 2]];
        SimulatedArm { tip: v(0), force: v(3), hand_force: v(6), is_output_on: n[9] == 1.0, violations: n[10] }
    }

    /// Norm of the force of the motors, N.
    fn force(&self, handle: u32) -> f64 {
        norm(self.arm(handle).force)
    }

    /// Moves the target of a hand (m) and sets its stiffness (N/m).
    fn set_hand(&self, handle: u32, target: [f64; 3], stiffness: f64) {
        let [x, y, z] = target;
        call_stub!(self, b"pliant_stub_set_hand\0", handle => u32, x => f64, y => f64, z => f64, stiffness => f64);
    }

    fn set_plugged(&self, plugged: bool) {
        call_stub!(self, b"pliant_stub_set_plugged\0", u8::from(plugged) => u8);
    }

    fn set_calibration(&self, calibration: u32, style: i32) {
        call_stub!(self, b"pliant_stub_set_calibration\0", calibration => u32, style => i32);
    }

    /// How often a force output that was on was switched off.
    fn outputs_off(&self) -> u64 {
        // SAFETY: the library has a function of that name without arguments.
        unsafe {
            let function: Symbol<'_, unsafe extern "C" fn() -> u64> =
                self.library.get(b"pliant_stub_outputs_off\0").expect("exported");
            function()
        }
    }

    /// Lets the next frame end with an error.
    fn inject_error(&self, code: u32) {
        call_stub!(self, b"pliant_stub_inject_error\0", code => u32);
    }
}

/// Opens the device with the replaced library and these parameters.
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

    /// Ticks with a force (N) until a condition holds; `what` names it in messages.
    fn tick_until(&mut self, force: [f64; 3], what: &str, holds: impl Fn(&Self) -> bool) {
        let begin = Instant::now();
        while !holds(self) {
            self.tick(force).unwrap_or_else(|e| panic!("{what}: {e}"));
            assert!(begin.elapsed() < Duration::from_secs(20), "{what}: not within 20 s");
        }
    }

    fn is_valid(&self, arm: usize) -> bool {
        self.poses[arm].flags & POSE_VALID != 0
    }

    /// A counter of the device by its name.
    fn count(&self, name: &str) -> u64 {
        let all = (0..).map_while(|i| self.device.counter(i));
        all.into_iter().find(|(n, _)| n.to_str() == Ok(name)).unwrap_or_else(|| panic!("{name}")).1
    }
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

#[test]
fn the_pose_is_that_of_the_arm_and_the_force_reaches_the_hand() {
    let stub = Stub::new();
    let device = open(&[]).unwrap_or_else(|e| panic!("{e}"));
    let info = device.describe();
    assert_eq!((info.peak_force, info.continuous_force, info.stiffness, info.rate), (3.3, 0.88, 500.0, 1000.0));
    assert_eq!(info.workspace, [-0.08, -0.06, -0.035, 0.08, 0.06, 0.035]);
    let mut host = Host::new(&device);
    stub.set_hand(0, [0.02, 0.0, 0.01], 300.0);
    let force = [0.0, 0.8, 0.0];
    host.tick_until(force, "equilibrium", |h| {
        let arm = stub.arm(0);
        let is_balanced = (arm.hand_force[1] + 0.8).abs() < 0.3;
        h.is_valid(0) && is_balanced && (arm.tip[0] - 0.02).abs() < 2e-3 && h.now() > 1_500 * MS
    });
    let (arm, pose) = (stub.arm(0), host.poses[0]);
    let error: f64 = (0..3).map(|c| (pose.position[c] - arm.tip[c]).abs()).fold(0.0, f64::max);
    println!("{arm:?}\nerror of the pose {error:e} m");
    assert!(error < 5e-4 && arm.is_output_on && norm(arm.force) <= 3.3);
    assert!((pose.orientation.iter().map(|q| q * q).sum::<f64>() - 1.0).abs() < 1e-9);
    // A larger force is limited to the peak, and a stop is immediate.
    host.tick_until([300.0, 0.0, 0.0], "peak force", |_| (stub.force(0) - 3.3).abs() < 1e-9);
    device.stop();
    let stopped = Instant::now();
    while stub.arm(0).force != [0.0; 3] {
        assert!(stopped.elapsed() < Duration::from_secs(5), "the stop has no effect");
        std::thread::sleep(Duration::from_millis(1));
    }
    // Every frame was begun and ended, and nothing was set or switched where the driver does not allow it.
    assert_eq!(stub.arm(0).violations, 0.0);
}

#[test]
fn the_force_expires_when_the_host_stops_writing() {
    let stub = Stub::new();
    let device = open(&[]).unwrap_or_else(|e| panic!("{e}"));
    let mut host = Host::new(&device);
    host.tick_until([1.0, 0.0, 0.0], "force", |_| stub.force(0) > 0.9);
    let last = Instant::now();
    while stub.force(0) > 0.0 {
        assert!(last.elapsed() < Duration::from_secs(5), "the force does not end");
        std::thread::sleep(Duration::from_micros(200));
    }
    println!("zero {:.1} ms after the last write, which was valid for 50 ms", last.elapsed().as_secs_f64() * 1e3);
}

#[test]
fn every_error_code_has_the_effect_of_its_class() {
    let stub = Stub::new();
    let device = open(&[]).unwrap_or_else(|e| panic!("{e}"));
    let mut host = Host::new(&device);
    let force = [0.5, 0.0, 0.0];
    let unknown = ErrorCode { code: 0x0777, name: "unknown", class: ErrorClass::Unknown };
    for ErrorCode { code, name, class } in ERROR_CODES.iter().copied().chain([unknown]) {
        host.tick_until(force, name, |h| h.is_valid(0) && stub.force(0) > 0.4);
        let before = ["force errors", "losses", "usage and frame errors", "recoveries"].map(|c| host.count(c));
        let outputs_off = stub.outputs_off();
        stub.inject_error(code);
        // The servo loop stores the code before it counts the error, so wait for both.
        let counted =
            |h: &Host| ["force errors", "losses", "usage and frame errors"].map(|c| h.count(c)).iter().sum::<u64>();
        let counted_before: u64 = before[..3].iter().sum();
        host.tick_until(force, name, |h| h.count("newest error") == u64::from(code) && counted(h) > counted_before);
        let after = || ["force errors", "losses", "usage and frame errors", "recoveries"].map(|c| host.count(c));
        match class {
            ErrorClass::Force => {
                assert_eq!(after()[0], before[0] + 1, "{name}");
                // It is off for 100 ms, which a busy machine may sleep through.
                host.tick_until(force, name, |_| stub.outputs_off() == outputs_off + 1);
                // The output is switched on again, and the force rises.
                host.tick_until(force, name, |_| stub.arm(0).is_output_on);
                host.tick_until(force, name, |_| stub.force(0) > 0.49);
            }
            ErrorClass::Lost | ErrorClass::Unknown | ErrorClass::Licence => {
                assert_eq!(after()[1], before[1] + 1, "{name}");
                host.tick_until(force, name, |h| h.count("recoveries") > before[3]);
            }
            ErrorClass::Usage | ErrorClass::Frame | ErrorClass::Scheduler => {
                assert_eq!(after()[2], before[2] + 1, "{name}")
            }
        }
    }
    assert_eq!(stub.arm(0).violations, 0.0);
    println!("{} codes", ERROR_CODES.len() + 1);
}

#[test]
fn an_unplugged_arm_is_opened_again_or_reported_as_lost() {
    let stub = Stub::new();
    let device = open(&[]).unwrap_or_else(|e| panic!("{e}"));
    let mut host = Host::new(&device);
    host.tick_until([1.0, 0.0, 0.0], "force", |h| h.is_valid(0) && stub.force(0) > 0.9);
    stub.set_plugged(false);
    host.tick_until([1.0, 0.0, 0.0], "the loss", |h| !h.is_valid(0));
    assert!(stub.force(0) == 0.0 || stub.arm(0).force[0].is_nan());
    stub.set_plugged(true);
    host.tick_until([1.0, 0.0, 0.0], "the arm", |h| h.is_valid(0) && stub.force(0) > 0.9);
    assert!(host.count("recoveries") >= 1);
    // If it stays unplugged, `read` reports the loss.
    drop(device);
    let device = open(&[("lost-after", Value::Number(0.3))]).unwrap_or_else(|e| panic!("{e}"));
    let mut host = Host::new(&device);
    host.tick_until([0.0; 3], "a pose", |h| h.is_valid(0));
    stub.set_plugged(false);
    let begun = Instant::now();
    let fault = loop {
        if let Err(fault) = host.tick([0.0; 3]) {
            break fault;
        }
        assert!(begun.elapsed() < Duration::from_secs(10), "the loss is not reported");
    };
    assert!(fault.reason.contains("without a pose"), "{fault}");
}

#[test]
fn a_stalled_servo_loop_gives_no_pose_until_it_continues() {
    let stub = Stub::new();
    let device = open(&[]).unwrap_or_else(|e| panic!("{e}"));
    let mut host = Host::new(&device);
    host.tick_until([0.0; 3], "a pose", |h| h.is_valid(0));
    call_stub!(stub, b"pliant_stub_stall\0", 400 => u64);
    host.tick_until([0.5, 0.0, 0.0], "the stall", |h| !h.is_valid(0));
    assert!(host.count("reads without a pose") > 0);
    host.tick_until([0.5, 0.0, 0.0], "the end of it", |h| h.is_valid(0));
}

#[test]
fn two_arms_are_two_effectors() {
    let stub = Stub::new();
    let arms = [("arm", Value::Text("left".into())), ("second-arm", Value::Text("right".into()))];
    let device = open(&arms).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(device.describe().effectors, 2);
    stub.set_hand(0, [-0.03, 0.0, 0.0], 300.0);
    stub.set_hand(1, [0.03, 0.0, 0.0], 300.0);
    let mut host = Host::new(&device);
    host.tick_until([0.0; 3], "both", |h| {
        (h.poses[0].position[0] + 0.03).abs() < 2e-3 && (h.poses[1].position[0] - 0.03).abs() < 2e-3
    });
    call_stub!(stub, b"pliant_stub_set_stylus\0", 1 => u32, 1 => i32, 0 => u8);
    host.tick_until([0.0; 3], "a button", |h| h.poses[1].buttons == 1 && h.poses[0].buttons == 0);
    // An arm with its stylus in the inkwell gets no force.
    call_stub!(stub, b"pliant_stub_set_stylus\0", 0 => u32, 0 => i32, 1 => u8);
    host.tick_until([1.0, 0.0, 0.0], "rest", |h| !h.is_valid(0) && stub.force(0) == 0.0 && stub.force(1) > 0.9);
    let again = open(&[]).err().expect("one driver has one scheduler");
    assert!(again.reason.contains("in use"), "{again}");
    assert_eq!(stub.arm(0).violations, 0.0);
}

#[test]
fn the_calibration_is_updated_or_asked_for() {
    let stub = Stub::new();
    stub.set_calibration(0x5001, 2);
    drop(open(&[]).unwrap_or_else(|e| panic!("{e}")));
    stub.set_calibration(0x5002, 4);
    let fault = open(&[("patience", Value::Number(0.1))]).err().expect("not calibrated");
    assert!(fault.reason.contains("inkwell"), "{fault}");
    stub.set_calibration(0x5002, 1);
    let fault = open(&[("patience", Value::Number(0.1))]).err().expect("not calibrated");
    assert!(fault.reason.contains("vendor's calibration"), "{fault}");
    stub.set_calibration(0x5000, 2);
    drop(open(&[]).unwrap_or_else(|e| panic!("opening after failures: {e}")));
}

#[test]
fn failures_to_open_name_the_cause_and_a_remedy() {
    let stub = Stub::new();
    let fault = open(&[("library", Value::Text("/nowhere/libHD.so".into()))]).err().expect("no library");
    assert!(fault.reason.contains("/nowhere/libHD.so"), "{fault}");
    let fault = open(&[("arm", Value::Text("nobody".into()))]).err().expect("no such arm");
    assert!(fault.reason.contains("`nobody`") && fault.reason.contains("HD_INVALID_VALUE"), "{fault}");
    stub.set_plugged(false);
    let fault = open(&[]).err().expect("unplugged");
    assert!(fault.reason.contains("HD_COMM_ERROR") && fault.reason.contains("cable"), "{fault}");
    stub.set_plugged(true);
    call_stub!(stub, b"pliant_stub_set_schedule_error\0", 0x0501 => u32);
    let fault = open(&[]).err().expect("full");
    assert!(fault.reason.contains("HD_SCHEDULER_FULL"), "{fault}");
    call_stub!(stub, b"pliant_stub_set_schedule_error\0", 0 => u32);
    // A rate the driver does not have is replaced by its own.
    let device = open(&[("rate", Value::Number(1234.0))]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(device.describe().rate, 1000.0);
}

#[test]
fn the_driver_is_opened_with_the_c_locale_of_numbers() {
    unsafe extern "C" {
        fn setlocale(category: i32, locale: *const std::ffi::c_char) -> *const std::ffi::c_char;
    }
    let stub = Stub::new();
    // SAFETY: C strings; the tests run one after the other.
    let set = |name: &std::ffi::CStr| unsafe { setlocale(1, name.as_ptr()) };
    assert!(!set(c"C.UTF-8").is_null(), "a locale every system has");
    drop(open(&[]).unwrap_or_else(|e| panic!("the driver opens under the locale C only: {e}")));
    // SAFETY: a query returns a C string.
    let after = unsafe { std::ffi::CStr::from_ptr(setlocale(1, std::ptr::null())) };
    assert_eq!(after.to_str().unwrap(), "C.UTF-8", "restored");
    set(c"C");
    drop(stub);
}

#[test]
fn the_shipped_scene_is_touched() {
    // Resets the library and waits for its users; the run has a process of its own.
    drop(Stub::new());
    let bench = Bench::new();
    let scene = root().join("scenes/phantom-touch.toml");
    let library = built("libHD.so");
    let set = format!("device.0.params.library=\"{}\"", library.display());
    let allowed = library.parent().unwrap().to_str().unwrap();
    let args = ["run", scene.to_str().unwrap(), "-q", "--out", "out", "--set", &set, "--allow-plugins", allowed];
    // The simulated hand comes down every two seconds of the clock, and a run that is not live may end before.
    bench.pliant(&[&args[..], &["--live", "--duration", "6 s"]].concat()).expect(0);
    let summary = bench.summary("out");
    assert!(summary["event_counts"].get("device-lost").is_none(), "{}", summary["events"]);
    let force = summary["probes"][0]["value"].as_f64().unwrap();
    println!("largest force {force} N");
    assert!((0.01..3.3).contains(&force), "{}", summary["probes"]);
    let found =
        bench.pliant(&["device", "doctor", "phantom", "--json", "--set", &format!("library={}", library.display())]);
    let found = found.expect(0).json();
    assert!(found["devices"][0]["findings"][1]["found"].as_str().unwrap().contains("Omni"), "{found}");
    let doctor = ["device", "doctor", "phantom", "--json", "--set", "library=/nowhere/libHD.so"];
    let missing = bench.pliant(&doctor).expect(1).json();
    let finding = &missing["devices"][0]["findings"][0];
    assert!(finding["state"] == "missing" && finding["what"] == "driver library", "{missing}");
    assert!(finding["remedy"].as_str().is_some_and(|remedy| remedy.contains("OpenHaptics")), "{missing}");
}

#[test]
fn a_scan_is_touched_live() {
    let bench = Bench::new();
    let mesh = bench.write("scan.obj", scan(0, 20_000, 3, 1).text);
    assert_touched_live(&bench, &mesh);
}

#[test]
#[ignore = "needs ../shared/meshes"]
fn the_bunny_is_touched_live() {
    assert_touched_live(&Bench::new(), &shared_mesh("stanford-bunny.obj"));
}

fn assert_touched_live(bench: &Bench, mesh: &Path) {
    drop(Stub::new());
    let scene = root().join("scenes/phantom-touch.toml");
    let set = format!("device.0.params.library=\"{}\"", built("libHD.so").display());
    let args = ["run", scene.to_str().unwrap(), "--mesh", mesh.to_str().unwrap(), "-q", "--live", "--out", "out"];
    // The simulated hand comes down every two seconds, so a run of 6 s on a slow machine has a contact too.
    let allowed = deps();
    let more = ["--duration", "6 s", "--set", &set, "--allow-plugins", allowed.to_str().unwrap()];
    bench.pliant(&[&args[..], &more].concat()).expect(0);
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
fn the_plugin_passes_the_conformance_suite() {
    drop(Stub::new());
    let bench = Bench::new();
    let folder = built("libHD.so").parent().unwrap().to_path_buf();
    let plugin = built("libpliant_phantom.so");
    // The whole suite: its cases open the device many times, and a driver can be opened once at a time.
    let path = [("LD_LIBRARY_PATH", folder.to_str().unwrap())];
    let told = bench.pliant_with(&["plugin", "check", plugin.to_str().unwrap(), "--json"], &path).expect(0).json();
    // Its allocations are counted where a test links it.
    assert!(told["skipped"] == 1 && told["failed"] == 0, "{told}");
    for case in CASES_OF_A_DEVICE.iter().chain(&["opens-many-times", "opens-with-defaults"]) {
        let rows = told["cases"].as_array().unwrap();
        assert!(rows.iter().any(|row| row["case"] == **case && row["verdict"] == "ok"), "{case} in {told}");
    }
}
