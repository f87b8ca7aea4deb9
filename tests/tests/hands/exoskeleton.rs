//! The exoskeleton plugin and its twin, which is a process of its own: the impairments of the network are counted, and when one side is
//! killed, poses and forces on the other side expire.

use pliant_exoskeleton::Exoskeleton;
use pliant_exoskeleton::link::DEFAULT_PEER;
use pliant_plugin_api::Device;
use pliant_plugin_api::abi::{Output, Pose};
use pliant_plugin_api::param::{self, Params, Value};
use pliant_tests::twin::{CASES_OF_A_DEVICE, Twin};
use pliant_tests::{Bench, built, root};
use serde_json::Value as Json;
use std::time::{Duration, Instant};

/// ns
const MS: u64 = 1_000_000;

fn open(peer: &str) -> Exoskeleton {
    let mut values = param::defaults(Exoskeleton::INFO.params);
    values[param::position(Exoskeleton::INFO.params, "peer").unwrap()] = Value::Text(peer.into());
    values[param::position(Exoskeleton::INFO.params, "patience").unwrap()] = Value::Number(20.0);
    Exoskeleton::new(&Params::new(Exoskeleton::INFO.params, &values)).unwrap_or_else(|e| panic!("{e}"))
}

fn output(force: f64, valid_until_ns: u64) -> [Output; 2] {
    let output = Output {
        size: size_of::<Output>(),
        force: [force, 0.0, 0.0],
        torque: [0.0; 3],
        taxels: std::ptr::null(),
        valid_until_ns,
    };
    [output; 2]
}

fn counters(device: &Exoskeleton) -> impl Fn(&str) -> u64 {
    let all: Vec<_> = (0..).map_while(|i| device.counter(i)).collect();
    move |name| all.iter().find(|(n, _)| n.to_str() == Ok(name)).unwrap_or_else(|| panic!("{name}")).1
}

fn number(of: &Json, key: &str) -> u64 {
    of[key].as_u64().unwrap_or_else(|| panic!("`{key}` in {of}"))
}

/// Datagrams the system dropped because nobody took them in time, of the socket on a port.
fn dropped_by_the_system(port: u16) -> u64 {
    let table = std::fs::read_to_string("/proc/net/udp").unwrap_or_default();
    let ours = format!(":{port:04X}");
    let row = table.lines().find(|l| l.split_whitespace().nth(1).is_some_and(|a| a.ends_with(&ours)));
    row.and_then(|l| l.split_whitespace().last()).and_then(|d| d.parse().ok()).unwrap_or(0)
}

#[test]
fn every_lost_late_and_repeated_datagram_is_counted() {
    let impairments = ["--loss", "0.2", "--jitter", "5", "--duplicates", "0.1", "--reorder", "0.1", "--for", "4"];
    let mut twin = Twin::exoskeleton(&impairments);
    let device = open(&twin.address);
    let start = Instant::now();
    let (mut poses, mut held, mut stale) = ([Pose::default(); 2], 0_u64, 0_u64);
    let now = || start.elapsed().as_nanos() as u64;
    let end = loop {
        // The last pose of the twin expires at once.
        device.read(now(), &mut poses).unwrap_or_else(|e| panic!("{e}"));
        let holds = poses.iter().all(|p| p.flags & 1 == 1);
        (held, stale) = if holds { (held + 1, stale) } else { (held, stale + 1) };
        device.write(now(), &output(0.5, now() + 50 * MS)).unwrap();
        std::thread::sleep(Duration::from_millis(1));
        if held > 100 && !holds && start.elapsed() > Duration::from_secs(3) {
            break twin.until("end");
        }
        assert!(start.elapsed() < Duration::from_secs(60), "the twin does not end");
    };
    let port = device.link().local_address().unwrap().port();
    let dropped = dropped_by_the_system(port);
    let (count, poses) = (counters(&device), &end["injected"]["poses"]);
    println!("{end}\nheld {held}, not {stale}; the system dropped {dropped}");
    for (i, (name, value)) in (0..).map_while(|i| device.counter(i)).enumerate() {
        println!("{i} {name:?} {value}");
    }
    assert!(number(poses, "sent") > 500 && number(poses, "lost") > 50 && number(poses, "late") > 20, "{end}");
    assert_eq!(dropped, 0, "the machine is too busy for this test");
    assert_eq!(count("poses lost"), number(poses, "lost") + number(poses, "lost_last"));
    assert_eq!(count("poses duplicate"), number(poses, "duplicate"));
    assert_eq!(count("poses late"), number(poses, "late"));
    let arrived = count("poses accepted") + count("poses late");
    assert_eq!(arrived, number(poses, "sent") - count("poses lost") + 1, "the last pose bypasses the network");
    assert_eq!((count("datagrams malformed"), count("datagrams foreign")), (0, 0));
    // The other way: what the device received is what the network let through.
    let (commands, received) = (&end["injected"]["commands"], &end["received"]);
    assert_eq!(number(received, "lost"), number(commands, "lost"));
    assert_eq!(number(received, "duplicate"), number(commands, "duplicate"));
    assert_eq!(number(received, "late"), number(commands, "late"));
    assert!(number(&end, "commands_applied") > 300, "{end}");
}

#[test]
fn poses_and_forces_expire_when_the_twin_is_killed() {
    let mut twin = Twin::exoskeleton(&[]);
    let device = open(&twin.address);
    let start = Instant::now();
    let now = || start.elapsed().as_nanos() as u64;
    let mut poses = [Pose::default(); 2];
    for _ in 0..200 {
        device.read(now(), &mut poses).unwrap();
        device.write(now(), &output(1.0, now() + 50 * MS)).unwrap();
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(poses.iter().all(|p| p.flags & 1 == 1), "{:?}", device.link().counts());
    twin.kill();
    // The newest pose is valid for 50 ms after it was sent.
    let last = now() - device.link().receive().age_ns;
    let mut gone = None;
    while gone.is_none() && now() < last + 5_000 * MS {
        device.read(now(), &mut poses).unwrap();
        let at = now();
        if poses.iter().all(|p| p.flags & 1 == 0) {
            gone = Some(at - last);
        }
    }
    let gone = gone.expect("the poses expire");
    println!("the poses expire {:.3} ms after the last one arrived", gone as f64 * 1e-6);
    assert!(poses.iter().all(|p| p.flags == 0));
    // A written force expires too.
    let until = now() + 50 * MS;
    device.write(now(), &output(1.0, until)).unwrap();
    let mut rendered = output(0.0, 0);
    device.rendered(until - 1, &mut rendered).unwrap();
    assert_eq!(rendered[0].force[0], 1.0);
    device.rendered(until, &mut rendered).unwrap();
    assert_eq!(rendered[0].force[0], 0.0);
    // After `lost-after` (2 s) of silence `read` reports the loss.
    let fault = loop {
        assert!(now() < last + 60_000 * MS, "the loss is never reported");
        std::thread::sleep(Duration::from_millis(10));
        if let Err(fault) = device.read(now(), &mut poses) {
            break fault;
        }
    };
    assert!(fault.reason.contains("silent"), "{fault}");
}

#[test]
fn the_force_of_the_twin_ends_when_the_host_is_killed() {
    let mut twin = Twin::exoskeleton(&["--hand", "keyframed"]);
    let bench = Bench::new();
    let scene = root().join("scenes/exoskeleton-pinch.toml");
    let peer = format!("device.0.params.peer=\"{}\"", twin.address);
    let mut host = bench
        .command(&["run", scene.to_str().unwrap(), "-q", "--out", "out", "--set", &peer, "--set", "time.duration=1000"])
        .spawn()
        .unwrap();
    twin.until("connected");
    bench.wait_for_trace(&mut host, &[], |rows| rows.contains(",touch,"));
    host.kill().unwrap();
    host.wait().unwrap();
    let end = twin.until("force-ended");
    println!("{end}");
    let us = |key: &str| end[key].as_f64().unwrap();
    assert_eq!(end["reason"], "expired");
    assert_eq!(us("valid_us"), 50_000.0);
    // The force is zero from the expiry on; `since_command_us` is when the loop of the twin noticed. Both are rounded to doubles, of 1e-11 us.
    assert!(us("since_command_us") - us("since_expiry_us") <= us("valid_us") + 1e-9, "{end}");
    assert!(us("since_command_us") > 0.0 && us("since_expiry_us") >= 0.0);
}

#[test]
fn a_cloth_is_pinched_and_felt_on_both_tips() {
    let mut twin = Twin::exoskeleton(&["--once"]);
    let bench = Bench::new();
    let scene = root().join("scenes/exoskeleton-pinch.toml");
    let peer = format!("device.0.params.peer=\"{}\"", twin.address);
    bench.pliant(&["run", scene.to_str().unwrap(), "-q", "--out", "out", "--set", &peer]).expect(0);
    let end = twin.until("end");
    let summary = bench.summary("out");
    println!("{}\n{end}", summary["probes"]);
    for probe in summary["probes"].as_array().unwrap() {
        let force = probe["value"].as_f64().unwrap();
        assert!((0.01..5.0).contains(&force), "{probe}");
    }
    assert!(summary["event_counts"].get("device-lost").is_none(), "{}", summary["events"]);
    assert!(number(&end, "commands_applied") > 500 && number(&end["received"], "malformed") == 0, "{end}");
}

#[test]
fn doctor_says_what_is_missing_and_how_to_get_it() {
    let bench = Bench::new();
    let twin = Twin::exoskeleton(&[]);
    let peer = format!("peer={}", twin.address);
    let ran = bench.pliant(&["device", "doctor", "exoskeleton", "--set", &peer]).expect(0);
    assert!(ran.out.contains(&format!("good     device: answers at {}", twin.address)), "{}", ran.out);
    let ran = bench.pliant(&["device", "doctor", "exoskeleton", "--set", "peer=127.0.0.1:9", "--json"]).expect(1);
    let found = &ran.json()["devices"][0];
    assert_eq!(found["usable"], false);
    assert!(found["findings"][0]["remedy"].as_str().unwrap().contains("pliant device emulate exoskeleton"), "{found}");
    let ran = bench.pliant(&["device", "doctor", "exoskeleton", "--set", "rate=5"]).expect(2);
    ran.says(&["rate", "10"]);
    bench.pliant(&["device", "doctor", "cloth"]).expect(2).says(&["`cloth` is not a device"]);
    bench.pliant(&["device", "emulate", "nothing"]).expect(3).says(&["pliant-twin-nothing"]);
    let listed = bench.pliant(&["device", "list", "--json"]).expect(0).json();
    let ids: Vec<&str> = listed["devices"].as_array().unwrap().iter().filter_map(|d| d["id"].as_str()).collect();
    assert!(ids.contains(&"exoskeleton") && ids.contains(&"scripted"), "{ids:?}");
}

#[test]
fn exoskeleton_and_pointer_pass_the_conformance_suite() {
    let bench = Bench::new();
    for plugin in ["exoskeleton", "pointer"] {
        let library = built(&format!("libpliant_{plugin}.so"));
        // The suite opens the default address. If another process has it, a twin of another test answers there.
        let free = std::net::UdpSocket::bind(DEFAULT_PEER).is_ok();
        let twin = free.then(|| Twin::at(DEFAULT_PEER, &[]));
        for case in CASES_OF_A_DEVICE {
            let told =
                bench.pliant(&["plugin", "check", library.to_str().unwrap(), "--case", case, "--json"]).expect(0);
            let told = told.json();
            // A pointer that nobody moves has no valid pose.
            let is_idle = plugin == "pointer" && case == "poses-are-valid";
            assert!(
                told["ok"] != told["skipped"] && (told["skipped"] == 1) == is_idle && told["failed"] == 0,
                "{told}"
            );
        }
        drop(twin);
    }
}

/// A block of few cells, so that it opens at once, touched by the index of an exoskeleton.
const BLOCK: &str = r#"
format = 1
[time]
duration = "60 s"
dt = "2 ms"
[[body]]
shape = { kind = "box", cells = 4, size = [0.04, 0.04, 0.04] }
material = { plugin = "mass-spring", params = { young = "20 kPa", damping-time = "5 ms" } }
grid = { level = 3 }
[[device]]
name = "hand"
plugin = "exoskeleton"
[[tool]]
name = "index"
device = "hand"
effector = 0
radius = "8 mm"
[[edit]]
kind = "touch"
tool = "index"
"#;

/// The twin's `end` event and the summary of a live run with it; none if the system itself dropped datagrams, as a busy one does.
fn live_run_with_impairments() -> Option<(Json, Json)> {
    let impairments = ["--loss", "0.2", "--jitter", "5", "--duplicates", "0.1", "--reorder", "0.1", "--for", "6"];
    let mut twin = Twin::exoskeleton(&impairments);
    let bench = Bench::new();
    bench.write("scene.toml", BLOCK);
    let peer = format!("device.0.params.peer=\"{}\"", twin.address);
    // The run outlives the twin, so it receives the last pose, and it does not give up the silent device.
    let args = ["run", "scene.toml", "-q", "--live", "--out", "out", "--set", &peer];
    let more = ["--set", "device.0.params.lost-after=60", "--duration", "600 s"];
    let mut host = bench.command(&args).args(more).spawn().unwrap();
    let peer = twin.until("connected")["peer"].as_str().unwrap().to_owned();
    let end = twin.until("end");
    std::thread::sleep(Duration::from_millis(200));
    let dropped = dropped_by_the_system(peer.rsplit(':').next().unwrap().parse().unwrap());
    let kill = std::process::Command::new("kill").args(["-INT", &host.id().to_string()]).status().unwrap();
    assert!(kill.success() && host.wait().unwrap().code() == Some(130));
    let summary = bench.summary("out/interrupted");
    (dropped == 0).then_some((end, summary))
}

#[test]
fn a_live_run_reports_the_counters_of_its_device() {
    let runs = (0..4).find_map(|_| live_run_with_impairments());
    let (end, summary) = runs.expect("the machine is too busy for this test");
    let counted = |name: &str| number(&summary["devices"]["hand"], name);
    let (poses, received) = (&end["injected"]["poses"], &end["received"]);
    println!("{end}\n{}", summary["devices"]);
    assert!(number(poses, "sent") > 500 && number(poses, "lost") > 50 && number(poses, "late") > 20, "{end}");
    assert_eq!(counted("poses lost"), number(poses, "lost") + number(poses, "lost_last"));
    assert_eq!(counted("poses duplicate"), number(poses, "duplicate"));
    assert_eq!(counted("poses late"), number(poses, "late"));
    let arrived = counted("poses accepted") + counted("poses late");
    assert_eq!(arrived, number(poses, "sent") - counted("poses lost") + 1, "the last pose bypasses the network");
    assert_eq!((counted("datagrams malformed"), counted("datagrams foreign")), (0, 0));
    assert!(counted("commands sent") >= number(received, "accepted") + number(&end["injected"]["commands"], "lost"));
    assert!(counted("reads without a pose") > 0, "after the twin's end");
    // Every measure of force safety has its counter.
    let hand = &summary["live"]["hands"][0];
    assert_eq!(hand["changed"].as_object().unwrap().len(), 6, "{hand}");
    assert!(number(hand, "dropped") > 0, "no pose after the twin's end: {hand}");
}
