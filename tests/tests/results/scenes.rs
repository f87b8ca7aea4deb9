//! The scenes people are given run as they are, at full length, and what they expect is met.

use pliant_tests::{Bench, root};
use serde_json::Value;

/// Runs a scene as it is, and gives its summary.
fn run(name: &str) -> Value {
    let bench = Bench::new();
    let path = root().join("scenes").join(name);
    bench.pliant(&["run", path.to_str().expect("UTF-8"), "-q", "--out", "out"]).expect(0);
    let summary = bench.summary("out");
    assert_eq!(summary["interrupted"], false);
    let number = |key: &str| summary[key].as_f64().unwrap_or_else(|| panic!("{name}: {key}"));
    assert!((number("simulated_seconds") - number("steps") * number("dt")).abs() < 1e-9, "{name}");
    for kind in ["quarantine", "device-lost", "not-converged", "sample-dropped", "speed-limit"] {
        assert!(summary["event_counts"].get(kind).is_none(), "{name}: {kind} in {}", summary["events"]);
    }
    summary
}

fn scenes() -> Vec<String> {
    let entries = std::fs::read_dir(root().join("scenes")).expect("scenes/").flatten();
    // One that needs a device beside it is run with its twin, in the tests of that device.
    let alone = |path: &std::path::Path| {
        let text = std::fs::read_to_string(path).expect("readable");
        !["exoskeleton", "phantom"].iter().any(|device| text.contains(&format!("plugin = \"{device}\"")))
    };
    let scenes = entries.filter(|e| e.path().extension().is_some_and(|x| x == "toml") && alone(&e.path()));
    let mut scenes: Vec<String> = scenes.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    scenes.sort();
    scenes
}

#[test]
fn every_scene_runs_and_meets_what_it_expects() {
    let scenes = scenes();
    assert!(scenes.len() >= 3, "{scenes:?}");
    for name in scenes {
        let summary = run(&name);
        let probes = summary["probes"].as_array().expect("probes");
        assert!(!probes.is_empty(), "{name} measures nothing");
        for probe in probes {
            assert!(probe["value"].as_f64().is_some_and(f64::is_finite), "{name}: {probe}");
            let expects = !probe["expected"].is_null();
            assert_eq!(probe["passed"].as_bool(), expects.then_some(true), "{name}: {probe}");
            assert!(!expects || probe["source"].as_str().is_some_and(|s| !s.is_empty()), "{name}: {probe} from where?");
        }
        let left_out = summary["left_out"].as_array().expect("a list");
        assert!(!left_out.is_empty() && left_out.iter().all(|l| l["why"] != ""), "{name}");
    }
}

#[test]
fn a_touch_is_felt_and_a_pull_draws_the_surface_out() {
    let probe = |summary: &Value, i: usize| summary["probes"][i]["value"].as_f64().expect("a number");
    let touch = run("touch.toml");
    assert!((0.05..3.3).contains(&probe(&touch, 0)), "N within what the hand gives: {}", probe(&touch, 0));
    assert!((1e-3..1e-2).contains(&probe(&touch, 1)), "m: {}", probe(&touch, 1));
    let pull = run("pull.toml");
    assert!((0.1..3.0).contains(&probe(&pull, 0)), "N below what a pull lets go at: {}", probe(&pull, 0));
    assert!((5e-3..4e-2).contains(&probe(&pull, 1)), "m: {}", probe(&pull, 1));
}
