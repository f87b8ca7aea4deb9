//! The same scene gives the same bytes, run after run and with any number of threads.

use pliant_tests::{Bench, box_scene, root};
use serde_json::Value;

/// Keys of a summary that tell of the machine, of the clock, or of the threads themselves.
const OF_THE_RUN: [&str; 6] = ["wall_seconds", "open_seconds", "step_seconds", "peak_memory", "machine", "threads"];

/// A value without what differs between runs by its nature.
fn timeless(value: Value) -> Value {
    match value {
        Value::Object(map) => {
            let kept = map.into_iter().filter(|(key, _)| !OF_THE_RUN.contains(&key.as_str()));
            Value::Object(kept.map(|(key, value)| (key, timeless(value))).collect())
        }
        Value::Array(list) => Value::Array(list.into_iter().map(timeless).collect()),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => value,
    }
}

/// The trace without its last column, the seconds a step took.
fn untimed(trace: &[u8]) -> String {
    let text = std::str::from_utf8(trace).expect("UTF-8");
    let head = text.lines().next().expect("a head");
    assert!(head.ends_with(",step_seconds"), "{head}");
    text.lines().map(|row| row.rsplit_once(',').expect("columns").0.to_owned() + "\n").collect()
}

/// Everything a run left, by name, as it must be again.
fn results(bench: &Bench, out: &str) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<String> = bench.names(out).into_iter().filter(|name| name != "frames").collect();
    files.extend(bench.names(&format!("{out}/frames")).into_iter().map(|name| format!("frames/{name}")));
    assert!(files.len() > 6, "{files:?}");
    let read = |name: String| {
        let bytes = bench.read(&format!("{out}/{name}"));
        let bytes = match name.as_str() {
            "trace.csv" => untimed(&bytes).into_bytes(),
            "summary.json" => timeless(bench.summary(out)).to_string().into_bytes(),
            _ => bytes,
        };
        (name, bytes)
    };
    files.into_iter().map(read).collect()
}

/// Asserts that results have the same names and bytes.
fn assert_same(first: &[(String, Vec<u8>)], now: &[(String, Vec<u8>)], what: &str) {
    for ((name, a), (other, b)) in first.iter().zip(now) {
        let at = a.iter().zip(b).position(|(a, b)| a != b);
        assert!(name == other && a == b, "{what}: {name} differs, at byte {at:?}");
    }
    assert_eq!(first.len(), now.len(), "{what}");
}

/// Runs `scene.toml` on each vector unit that the processor has, and compares.
///
/// # Panics
/// If anything differs.
fn the_same_on_any_vector_unit(bench: &Bench, settings: &[&str], what: &str) {
    let mut first = None;
    for unit in ["", "avx2", "none"] {
        let mut args = vec!["run", "scene.toml", "-q", "--out", "out", "--threads", "1"];
        settings.iter().for_each(|set| args.extend(["--set", set]));
        let ran = bench.pliant_with(&args, &[("PLIANT_VECTOR_UNIT", unit)]);
        if unit == "avx2" && ran.err.contains("does not have") {
            continue;
        }
        ran.expect(0);
        let now = results(bench, "out");
        assert_same(first.get_or_insert_with(|| now.clone()), &now, &format!("{what}: `{unit}`"));
    }
}

/// Runs `scene.toml` twice with one thread, then with more, and compares.
///
/// # Panics
/// If anything differs, or if nothing happened that could have.
fn the_same_for_any_number_of_threads(bench: &Bench, settings: &[&str], what: &str) {
    let mut first: Option<Vec<(String, Vec<u8>)>> = None;
    for (turn, threads) in ["1", "1", "2", "4"].iter().enumerate() {
        let mut args = vec!["run", "scene.toml", "-q", "--out", "out", "--oversubscribe", "--threads", threads];
        settings.iter().for_each(|set| args.extend(["--set", set]));
        bench.pliant(&args).expect(0);
        let summary = bench.summary("out");
        assert_eq!(summary["choices"]["threads"].to_string(), **threads, "{what}: they were there");
        let now = results(bench, "out");
        let Some(first) = &first else {
            let number = |key: &str| summary[key].as_u64().unwrap_or_else(|| panic!("{key}: {summary}"));
            assert!(number("contact_steps") > 10 && number("most_elements") > 1500, "{what}: worth sharing: {summary}");
            first = Some(now);
            continue;
        };
        assert_same(first, &now, &format!("{what}: run {turn}, {threads} threads"));
    }
}

/// The box of the other tests with finer cells, and a hand that presses or pulls.
fn scene(kind: &str) -> String {
    let edit = if kind == "pull" { "kind = \"pull\"\nrelease = \"keep\"\nend = 0.04" } else { "kind = \"touch\"" };
    let path = match kind {
        "pull" => "path = [[0.0, 0.0, 0.0, 0.003], [0.005, 0.0, 0.0, 0.003], [0.05, 0.002, 0.0, 0.012]]",
        _ => "path = [[0.0, 0.0, 0.0, 0.006], [0.02, 0.0, 0.0, 0.001], [0.05, 0.008, 0.0, 0.001]]",
    };
    box_scene("", "", "[output]\nframes = 100")
        .replace("level = 5", "level = 6")
        .replace("kind = \"touch\"", edit)
        .replace("path = [[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001], [0.05, 0.002, 0.0, 0.001]]", path)
}

#[test]
fn another_scene_has_other_bytes() {
    let bench = Bench::new();
    bench.write("scene.toml", scene("touch"));
    for (out, radius) in [("first", "4 mm"), ("second", "4.0001 mm")] {
        let set = format!("tool.0.radius={radius}");
        bench.pliant(&["run", "scene.toml", "-q", "--out", out, "--set", &set]).expect(0);
    }
    for ((name, a), (_, b)) in results(&bench, "first").iter().zip(&results(&bench, "second")) {
        // A finger that is still in the air has moved nothing.
        assert_eq!(a == b, name == "frames/frame-00000.obj", "{name}: what is compared would show a difference");
    }
}

#[test]
fn a_touch_has_the_same_bytes_for_any_number_of_threads() {
    let bench = Bench::new();
    bench.write("scene.toml", scene("touch"));
    for integrator in ["symplectic-euler", "backward-euler"] {
        let set = format!("time.integrator={integrator}");
        the_same_for_any_number_of_threads(&bench, &[&set], &format!("touch, {integrator}"));
    }
}

#[test]
fn a_pull_that_is_kept_has_the_same_bytes_for_any_number_of_threads() {
    let bench = Bench::new();
    bench.write("scene.toml", scene("pull"));
    for integrator in ["symplectic-euler", "backward-euler"] {
        let set = format!("time.integrator={integrator}");
        the_same_for_any_number_of_threads(&bench, &[&set], &format!("pull, {integrator}"));
    }
}

#[test]
fn materials_have_the_same_bytes_on_any_vector_unit() {
    let bench = Bench::new();
    let held = "[[body.fixed]]\nbox = [[-1.0, -1.0, -1.0], [1.0, 1.0, -0.019]]";
    bench.write("scene.toml", scene("touch").replace("[[device]]", &format!("{held}\n[[device]]")));
    for material in ["mass-spring", "neo-hookean", "corotational"] {
        for integrator in ["symplectic-euler", "backward-euler"] {
            let set = [
                format!("body.0.material={{ plugin = \"{material}\", params = {{ young = 2e4, density = 1000 }} }}"),
                format!("time.integrator={integrator}"),
                "body.0.grid.region=whole".to_owned(),
                "body.0.grid.level=5".to_owned(),
            ];
            let set: Vec<&str> = set.iter().map(String::as_str).collect();
            the_same_on_any_vector_unit(&bench, &set, &format!("{material}, {integrator}"));
        }
    }
    bench.write("scene.toml", CLOTH);
    the_same_on_any_vector_unit(&bench, &[], "cloth");
    let ran = bench.pliant_with(&["run", "scene.toml"], &[("PLIANT_VECTOR_UNIT", "avx3")]);
    let error = ran.expect(2).err;
    assert!(error.contains("avx3") && error.contains("avx2"), "{error}");
}

#[test]
fn the_printed_scheme_has_the_same_bytes_while_it_grows() {
    let bench = Bench::new();
    bench.write("scene.toml", scene("touch"));
    let settings = [
        "time.integrator=explicit-euler",
        "time.force-unstable=true",
        // Above its limit of growth, and slow enough that the hand stays in contact while the motion grows.
        "time.substeps=10",
        "body.0.material.params={ damping-time = 0.0005, volume-resistance = 0.0 }",
    ];
    the_same_for_any_number_of_threads(&bench, &settings, "explicit-euler");
}

#[test]
fn a_whole_body_under_gravity_has_the_same_bytes_for_any_number_of_threads() {
    let bench = Bench::new();
    let held = "[[body.fixed]]\nbox = [[-1.0, -1.0, -1.0], [1.0, 1.0, -0.019]]";
    bench.write("scene.toml", scene("touch").replace("[[device]]", &format!("{held}\n[[device]]")));
    for integrator in ["symplectic-euler", "backward-euler"] {
        let set = format!("time.integrator={integrator}");
        let settings = [&*set, "gravity=[0, 0, -9.81]", "body.0.grid.region=whole", "body.0.grid.level=5"];
        the_same_for_any_number_of_threads(&bench, &settings, &format!("whole, {integrator}"));
    }
}

#[test]
fn the_scenes_that_are_given_have_the_same_bytes_for_any_number_of_threads() {
    for name in ["touch.toml", "pull.toml"] {
        let bench = Bench::new();
        for file in [name, "elephant.obj", "elephant.mtl"] {
            let to = if file == name { "scene.toml" } else { file };
            bench.write(to, std::fs::read(root().join("scenes").join(file)).expect("read"));
        }
        let settings = ["time.duration=0.2", "output.frames=50"];
        the_same_for_any_number_of_threads(&bench, &settings, name);
    }
}

/// A finger presses into a hanging cloth.
const CLOTH: &str = r#"format = 1
gravity = [0, -9.81, 0]
[time]
duration = 0.03
integrator = "backward-euler"
[solver]
tolerance = 1e-4
[[body]]
name = "cloth"
shape = { kind = "sheet", cells = 52, size = [0.2, 0.2, 0], pattern = "irregular" }
sheet = { warp = [1, 0.3, 0] }
material = { plugin = "cloth", params = { fabric = "denim" } }
[[body.fixed]]
box = [[-1, 0.199, -1], [1, 1, 1]]
clamp = true
[[device]]
name = "hand"
params = { path = [[0, 0.1, 0.1, 0.0085], [0.01, 0.1, 0.1, 0.006], [0.03, 0.104, 0.1, 0.004]] }
[[tool]]
name = "finger"
device = "hand"
radius = "8 mm"
[[edit]]
kind = "touch"
tool = "finger"
[output]
frames = 100
forces = true
"#;

#[test]
fn a_cloth_with_contact_gives_the_same_bytes_for_any_number_of_threads() {
    let bench = Bench::new();
    bench.write("scene.toml", CLOTH);
    for bending in ["coupled", "hinge", "projected-laplacian"] {
        let set = format!("body.0.material.params={{ fabric = \"denim\", bending = \"{bending}\" }}");
        the_same_for_any_number_of_threads(&bench, &[&set], bending);
    }
}

#[test]
fn a_body_that_one_thread_may_step_sooner_has_the_same_bytes() {
    let bench = Bench::new();
    bench.write("scene.toml", CLOTH);
    // One thread is tried after 64 steps.
    the_same_for_any_number_of_threads(&bench, &["body.0.shape.cells=31", "time.duration=0.15"], "31 cells");
}

#[test]
fn a_large_cloth_whose_levels_are_halved_one_way_at_a_time_has_the_same_bytes() {
    let bench = Bench::new();
    bench.write("scene.toml", CLOTH);
    the_same_for_any_number_of_threads(&bench, &["body.0.shape.cells=95", "time.duration=0.02"], "95 cells");
}
