//! The exoskeleton against its twin as a process of its own: a bad network is counted, and whoever is left falls to zero.

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
fn a_bad_network_is_counted_to_the_last_datagram() {
    let weather = ["--loss", "0.2", "--jitter", "5", "--duplicates", "0.1", "--reorder", "0.1", "--for", "4"];
    let mut twin = Twin::exoskeleton(&weather);
    let device = open(&twin.address);
    let start = Instant::now();
    let (mut poses, mut held, mut stale) = ([Pose::default(); 2], 0_u64, 0_u64);
    let now = || start.elapsed().as_nanos() as u64;
    let end = loop {
        // The last word of the twin ends what it said before.
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
    let port = device.link().local().unwrap().port();
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
    let arrived = count("poses taken") + count("poses late");
    assert_eq!(arrived, number(poses, "sent") - count("poses lost") + 1, "and the last word");
    assert_eq!((count("datagrams malformed"), count("datagrams foreign")), (0, 0));
    // The other way: what the device received is what the network let through.
    let (commands, received) = (&end["injected"]["commands"], &end["received"]);
    assert_eq!(number(received, "lost"), number(commands, "lost"));
    assert_eq!(number(received, "duplicate"), number(commands, "duplicate"));
    assert_eq!(number(received, "late"), number(commands, "late"));
    assert!(number(&end, "obeyed") > 300, "{end}");
}

#[test]
fn a_twin_that_is_killed_leaves_no_pose_and_no_force() {
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
    // The newest pose says itself until when it holds: 50 ms after it was sent.
    let last = now() - device.link().hear().age;
    let mut gone = None;
    while gone.is_none() && now() < last + 5_000 * MS {
        device.read(now(), &mut poses).unwrap();
        let at = now();
        if poses.iter().all(|p| p.flags & 1 == 0) {
            gone = Some(at - last);
        }
    }
    let gone = gone.expect("the poses end");
    println!("poses end {:.3} ms after the last one arrived", gone as f64 * 1e-6);
    assert!(poses.iter().all(|p| p.flags == 0));
    // A force that was written is over when its time is.
    let until = now() + 50 * MS;
    device.write(now(), &output(1.0, until)).unwrap();
    let mut felt = output(0.0, 0);
    device.rendered(until - 1, &mut felt).unwrap();
    assert_eq!(felt[0].force[0], 1.0);
    device.rendered(until, &mut felt).unwrap();
    assert_eq!(felt[0].force[0], 0.0);
    // Long silence is a loss that is told.
    std::thread::sleep(Duration::from_millis(2100));
    let fault = device.read(now(), &mut poses).unwrap_err();
    assert!(fault.reason.contains("silent"), "{fault}");
}

#[test]
fn a_host_that_is_killed_leaves_no_force() {
    let mut twin = Twin::exoskeleton(&["--hand", "keyframed"]);
    let bench = Bench::new();
    let scene = root().join("scenes/exoskeleton-pinch.toml");
    let peer = format!("device.0.params.peer=\"{}\"", twin.address);
    let mut host = bench
        .command(&["run", scene.to_str().unwrap(), "-q", "--out", "out", "--set", &peer, "--set", "time.duration=1000"])
        .spawn()
        .unwrap();
    twin.until("met");
    // In the middle of the touch.
    std::thread::sleep(Duration::from_millis(2500));
    host.kill().unwrap();
    host.wait().unwrap();
    let zero = twin.until("zero");
    println!("{zero}");
    let us = |key: &str| zero[key].as_f64().unwrap();
    assert_eq!(zero["why"], "expired");
    assert_eq!(us("valid_us"), 50_000.0);
    // The force is a function of time and zero past its deadline; `after` is when the twin's own loop saw it.
    assert!(us("after_us") - us("past_us") <= us("valid_us"), "{zero}");
    assert!(us("after_us") > 0.0 && us("past_us") >= 0.0);
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
    assert!(number(&end, "obeyed") > 500 && number(&end["received"], "malformed") == 0, "{end}");
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
fn it_and_the_pointer_keep_the_promises_of_a_device() {
    let bench = Bench::new();
    for plugin in ["exoskeleton", "pointer"] {
        let library = built(&format!("libpliant_{plugin}.so"));
        // Its address is the default one: where that is taken, what answers there is as good.
        let free = std::net::UdpSocket::bind(DEFAULT_PEER).is_ok();
        let twin = free.then(|| Twin::at(DEFAULT_PEER, &[]));
        for case in CASES_OF_A_DEVICE {
            let ran = bench.pliant(&["plugin", "check", library.to_str().unwrap(), "--case", case]).expect(0);
            assert!(ran.out.contains("ok ") && !ran.out.contains("skipped"), "{}", ran.out);
        }
        drop(twin);
    }
}

/// A block of few cells, so that it is open at once, and both fingers of an exoskeleton.
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

/// The twin's last word and the summary of a live run with it, unless the system itself dropped datagrams, as a busy one does.
fn live_run_in_bad_weather() -> Option<(Json, Json)> {
    let weather = ["--loss", "0.2", "--jitter", "5", "--duplicates", "0.1", "--reorder", "0.1", "--for", "6"];
    let mut twin = Twin::exoskeleton(&weather);
    let bench = Bench::new();
    bench.write("scene.toml", BLOCK);
    let peer = format!("device.0.params.peer=\"{}\"", twin.address);
    // It outlives the twin, whose last word is thus heard, and does not give it up.
    let args = ["run", "scene.toml", "-q", "--live", "--out", "out", "--set", &peer];
    let more = ["--set", "device.0.params.lost-after=60", "--duration", "600 s"];
    let mut host = bench.command(&args).args(more).spawn().unwrap();
    let peer = twin.until("met")["peer"].as_str().unwrap().to_owned();
    let end = twin.until("end");
    std::thread::sleep(Duration::from_millis(200));
    let dropped = dropped_by_the_system(peer.rsplit(':').next().unwrap().parse().unwrap());
    let kill = std::process::Command::new("kill").args(["-INT", &host.id().to_string()]).status().unwrap();
    assert!(kill.success() && host.wait().unwrap().code() == Some(130));
    let summary = bench.summary("out/interrupted");
    (dropped == 0).then_some((end, summary))
}

#[test]
fn a_live_run_tells_what_its_device_counted() {
    let runs = (0..4).find_map(|_| live_run_in_bad_weather());
    let (end, summary) = runs.expect("the machine is too busy for this test");
    let counted = |name: &str| number(&summary["devices"]["hand"], name);
    let (poses, received) = (&end["injected"]["poses"], &end["received"]);
    println!("{end}\n{}", summary["devices"]);
    assert!(number(poses, "sent") > 500 && number(poses, "lost") > 50 && number(poses, "late") > 20, "{end}");
    assert_eq!(counted("poses lost"), number(poses, "lost") + number(poses, "lost_last"));
    assert_eq!(counted("poses duplicate"), number(poses, "duplicate"));
    assert_eq!(counted("poses late"), number(poses, "late"));
    let arrived = counted("poses taken") + counted("poses late");
    assert_eq!(arrived, number(poses, "sent") - counted("poses lost") + 1, "and the last word");
    assert_eq!((counted("datagrams malformed"), counted("datagrams foreign")), (0, 0));
    assert!(counted("commands sent") >= number(received, "taken") + number(&end["injected"]["commands"], "lost"));
    assert!(counted("reads without a pose") > 0, "after the twin's end");
    // And every cause that may change a force has its counter.
    let hand = &summary["live"]["hands"][0];
    assert_eq!(hand["changed"].as_object().unwrap().len(), 6, "{hand}");
    assert!(number(hand, "dropped") > 0, "no pose after the twin's end: {hand}");
}
