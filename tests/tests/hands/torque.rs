//! Torque on a hand whose device drives six axes: within the peak it states and the slew rate, in a run and live, whatever the edit asks for.

use pliant_engine::session::EventKind;
use pliant_host::{DeviceInfo, EffectorOutput, Pose};
use pliant_live::{HapticDevice, Servo, StopDevice};
use pliant_plugin_api::abi::{POSE_VALID, Status};
use pliant_solver::Vec3;
use pliant_tests::{Bench, open_file, root};
use std::sync::{Arc, Mutex};

/// The shipped scene of an ear that is grabbed and turned, with a peak torque of its device, N m.
fn scene(bench: &Bench, peak: f64) -> std::path::PathBuf {
    let text = std::fs::read_to_string(root().join("scenes/grab.toml")).expect("a shipped scene");
    let stated = format!("peak-force = \"20 N\"\npeak-torque = {peak}");
    let text = text.replace("peak-force = \"20 N\"", &stated).replace("level = 6", "level = 5");
    for file in ["elephant.obj", "elephant.mtl"] {
        bench.write(file, std::fs::read(root().join("scenes").join(file)).expect("a shipped model"));
    }
    bench.write("grab.toml", text)
}

/// Torques on the device of each step of a run, N m.
fn run(peak: f64) -> (Vec<Vec3>, u64) {
    let bench = Bench::new();
    scene(&bench, peak);
    bench.pliant(&["run", "grab.toml", "-q", "--set", "time.duration=0.6", "--out", "out"]).expect(0);
    let trace = String::from_utf8(bench.read("out/trace.csv")).expect("UTF-8");
    let mut rows = trace.lines();
    let head: Vec<&str> = rows.next().expect("a head").split(',').collect();
    let column = |axis: &str| {
        let name = format!("fingers.device_torque_{axis}_Nm");
        head.iter().position(|column| *column == name).unwrap_or_else(|| panic!("{name} in {head:?}"))
    };
    let columns = ["x", "y", "z"].map(column);
    let torques = rows.map(|row| {
        let cells: Vec<&str> = row.split(',').collect();
        Vec3::from(columns.map(|c| cells[c].parse::<f64>().expect("a number")))
    });
    let torques = torques.collect();
    (torques, bench.summary("out")["event_counts"]["force-safety"].as_u64().unwrap_or(0))
}

fn largest(torques: &[Vec3]) -> f64 {
    torques.iter().map(|torque| torque.norm()).fold(0.0, f64::max)
}

#[test]
fn a_run_keeps_to_the_peak_torque_of_the_device() {
    let (free, calm) = run(1.0);
    let asked = largest(&free);
    assert!(asked > 1e-3, "the turn asks for {asked} N m");
    let peak = 0.4 * asked;
    let (limited, events) = run(peak);
    assert!((largest(&limited) / peak - 1.0).abs() < 1e-9, "{} of {peak} N m", largest(&limited));
    assert!(events > calm, "{events} events, {calm} without a limit");
    // 500 N/s (`slew`) times the lever, peak torque over peak force, in a step of 1 ms.
    let slew = 500.0 * peak / 20.0 * 1e-3;
    let change = limited.windows(2).map(|pair| (pair[1] - pair[0]).norm()).fold(0.0, f64::max);
    assert!(change <= slew * (1.0 + 1e-9), "{change} N m in a step");
    let without = run(0.0).0;
    assert_eq!(largest(&without), 0.0, "a device of three axes renders none");
}

#[test]
fn a_replay_has_the_torques_and_events_of_its_run() {
    let peak = 0.4 * largest(&run(1.0).0);
    let bench = Bench::new();
    scene(&bench, peak);
    let args = ["run", "grab.toml", "-q", "--set", "time.duration=0.6", "--record", "grab.rec", "--out", "out"];
    bench.pliant(&args).expect(0);
    bench.pliant(&["replay", "grab.rec", "-q", "--out", "again"]).expect(0);
    assert_eq!(bench.summary("out")["event_counts"], bench.summary("again")["event_counts"]);
    // All but the last column, the time that a step took.
    let [trace, again] = ["out", "again"].map(|out| {
        let text = String::from_utf8(bench.read(&format!("{out}/trace.csv"))).expect("UTF-8");
        text.lines().map(|row| row.rsplit_once(',').map_or("", |(row, _)| row).to_owned()).collect::<Vec<_>>()
    });
    assert!(trace.len() > 600 && trace == again, "trace.csv differs");
}

/// A device of six axes that is led along the path of the scene, and records its torques.
struct Twister {
    peak: f64,
    torques: Arc<Mutex<Vec<Vec3>>>,
}

impl HapticDevice for Twister {
    fn device_info(&self) -> DeviceInfo {
        DeviceInfo {
            effectors: 1,
            buttons: 1,
            driven_axes: 6,
            rate: 1000.0,
            peak_force: 20.0,
            continuous_force: 20.0,
            stiffness: 2000.0,
            damping: 5.0,
            peak_torque: self.peak,
            ..DeviceInfo::default()
        }
    }

    fn read(&mut self, time: u64, poses: &mut [Pose]) -> Status {
        let seconds = time as f64 * 1e-9;
        let angle = (0.7 * ((seconds - 0.1) / 0.3).clamp(0.0, 1.0)) / 2.0;
        let orientation = [0.0, 0.0, angle.sin(), angle.cos()];
        let buttons = u32::from(seconds > 0.1);
        let (flags, position) = (POSE_VALID, [0.0, 0.0, 0.002]);
        poses.fill(Pose { time_ns: time, flags, buttons, position, orientation, ..Pose::default() });
        Status::OK
    }

    fn write(&mut self, _: u64, outputs: &[EffectorOutput<'_>]) -> Status {
        self.torques.lock().expect("a lock").push(outputs[0].torque.into());
        Status::OK
    }

    fn stop_handle(&self) -> StopDevice {
        Box::new(|| {})
    }
}

/// Torques on a live hand, N m, at each tick of a millisecond; a step of the simulation every `every` ticks until it falls silent at 0.4 s.
fn live(peak: f64, every: u64) -> Vec<Vec3> {
    let bench = Bench::new();
    let mut session = open_file(&scene(&bench, peak), 1, None);
    drop(session.take_devices());
    let torques = Arc::default();
    let device = Twister { peak, torques: Arc::clone(&torques) };
    let (mut servo, mut port) = Servo::new(&session, vec![Box::new(device)], Some(1000.0));
    for tick in 0..700 {
        servo.tick(tick * 1_000_000);
        if tick % every == 0 && tick < 400 {
            port.step(&mut session, |_| {});
        }
    }
    assert_eq!(session.events.count(EventKind::Quarantine), 0);
    drop(servo);
    Arc::into_inner(torques).expect("no other").into_inner().expect("a lock")
}

#[test]
fn a_live_hand_feels_a_torque_within_its_limits_that_ends_with_the_simulation() {
    let asked = largest(&live(10.0, 1));
    assert!(asked > 1e-3, "the turn asks for {asked} N m");
    for every in [1, 4] {
        let peak = 0.4 * asked;
        let torques = live(peak, every);
        assert!(largest(&torques) <= peak * (1.0 + 1e-9) && largest(&torques) > 0.5 * peak, "{}", largest(&torques));
        let slew = 500.0 * peak / 20.0 * 1e-3;
        let change = torques[..600].windows(2).map(|pair| (pair[1] - pair[0]).norm()).fold(0.0, f64::max);
        assert!(change <= slew * (1.0 + 1e-9), "{change} N m in a tick");
        assert!(torques[390].norm() > 0.0 && torques[560..].iter().all(|torque| *torque == Vec3::zeros()), "{every}");
    }
    assert_eq!(largest(&live(0.0, 1)), 0.0, "a device that states no torque gets none");
}
