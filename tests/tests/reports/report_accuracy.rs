//! `pliant report accuracy` measures what is there: a material five per cent too soft, a case that is no case, a report that was
//! stopped and one that got worse are all told.

use pliant_tests::{Bench, Ran};
use serde_json::Value;

/// A bar of springs that hangs from its top, as a scene beside a catalogue of one case.
const SCENE: &str = r#"format = 1
gravity = [0, 0, -0.02]
[time]
duration = 1
dt = 1
integrator = "quasi-static"
[solver]
tolerance = 1e-8
[[body]]
shape = { kind = "box", cells = 4, size = [0.02, 0.02, 0.04] }
material = { plugin = "faulty-plugins#sound-springs" }
grid = { level = 4, region = "whole" }
[[body.fixed]]
box = [[-1, -1, 0.0199], [1, 1, 1]]
"#;

fn catalogue(expected: f64) -> String {
    format!(
        r#"
        [[case]]
        name = "bar"
        title = "a bar of springs"
        scene = "bar"
        source = "the same bar, measured"
        norm = "relative error of the lower end"
        tolerance = 1e-3
        at = 8
        over = "n"
        step = [1.0]
        level = [{{ n = 8 }}]
        measure = [{{ kind = "displacement", within = [[-1, -1, -1], [1, 1, -0.0199]], axis = [0, 0, -1], expected = {expected:e} }}]
        method = [
            {{ name = "sound", set = {{ "body.0.material.plugin" = "faulty-plugins#sound-springs" }} }},
            {{ name = "too soft", set = {{ "body.0.material.plugin" = "faulty-plugins#too-soft" }} }},
        ]
        "#
    )
}

/// Runs the case against an expected value.
fn report(bench: &Bench, expected: f64, more: &[&str]) -> Ran {
    bench.write("cases/bar.toml", SCENE);
    bench.write("cases/catalogue.toml", catalogue(expected));
    let args = ["report", "accuracy", "--catalogue", "cases/catalogue.toml", "-q", "--json", "--out", "out"];
    bench.pliant(&[&args[..], more].concat())
}

fn row<'a>(report: &'a Value, method: &str) -> &'a Value {
    let rows = report["rows"].as_array().expect("rows");
    rows.iter().find(|r| r["method"] == method).unwrap_or_else(|| panic!("{method} in {rows:?}"))
}

#[test]
fn a_material_that_is_five_per_cent_too_soft_is_told_from_one_that_is_not() {
    let bench = Bench::new();
    let first = report(&bench, 1.0, &[]).expect(0).json();
    let measured = row(&first, "sound")["found"]["value"].as_f64().expect("a value");
    assert!(measured > 0.0 && measured.is_finite(), "{first}");
    let ran = report(&bench, measured, &[]).expect(0).json();
    let (sound, soft) = (row(&ran, "sound"), row(&ran, "too soft"));
    assert_eq!((&sound["passed"], &soft["passed"]), (&Value::Bool(true), &Value::Bool(false)), "{ran}");
    let off = soft["error"].as_f64().expect("an error");
    assert!((off - 0.05 / 0.95).abs() < 5e-3, "5 % softer gives {off} more");
    assert_eq!((&ran["verdict"]["judged"], &ran["verdict"]["passed"]), (&2.into(), &1.into()));
    assert!(ran["verdict"]["missed"][0].as_str().is_some_and(|m| m.contains("too soft")), "{}", ran["verdict"]);
    let page = String::from_utf8(bench.read("out/report.html")).expect("UTF-8");
    assert!(page.contains("1 of 2 judged results") && page.contains("the error exceeds the tolerance"));
    for from in ["http://", "https://", "<script", "<link", "<img"] {
        let inside = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!inside.contains(from), "{from}: the page needs nothing from outside");
    }
    report(&bench, measured, &["--strict"]).expect(1);
    // What was right before and is not now.
    let before = bench.read("out/report.json");
    bench.write("before.json", before);
    report(&bench, measured, &["--baseline", "before.json"]).expect(0);
    let worse = report(&bench, 1.01 * measured, &["--baseline", "before.json"]).expect(1).json();
    assert!(worse["baseline"]["regressions"].as_array().is_some_and(|r| !r.is_empty()), "{}", worse["baseline"]);
}

#[test]
fn every_row_says_what_a_reader_of_it_needs() {
    let bench = Bench::new();
    let ran = report(&bench, 1.0, &["--threads", "2"]).expect(0).json();
    for row in ran["rows"].as_array().expect("rows") {
        for key in ["case", "method", "n", "dt", "threads", "error", "tolerance", "order", "expected_order", "passed"] {
            assert!(row.get(key).is_some(), "{key} in {row}");
        }
        assert!(row["wall_seconds"].as_f64() > Some(0.0) && row["cpu_seconds"].as_f64().is_some(), "{row}");
        assert_eq!(row["threads"], 2);
    }
    for key in ["settings", "seed", "program", "plugins", "machine", "clock"] {
        assert!(!ran[key].is_null(), "{key}");
    }
    assert!(ran["machine"]["cpu"].as_str().is_some_and(|c| !c.is_empty()) && ran["clock"]["passed"] == true, "{ran}");
    let csv = String::from_utf8(bench.read("out/report.csv")).expect("UTF-8");
    assert_eq!(csv.lines().count(), 3, "{csv}");
    assert!(!bench.names("out").contains(&"journal.jsonl".into()), "nothing is left to go on with");
    assert!(bench.names("out").iter().any(|n| n.ends_with(".svg")));
}

#[test]
fn a_report_that_was_stopped_goes_on_where_it_was() {
    let bench = Bench::new();
    let whole = report(&bench, 1.0, &[]).expect(0).json();
    // What a stopped run leaves: the line of its settings, and a line of each row it has.
    let asked = ["report", "accuracy", "--catalogue", "cases/catalogue.toml", "--out", "out"];
    let settings = serde_json::json!({ "program": env!("CARGO_PKG_VERSION"), "command": asked }).to_string();
    let mut row = row(&whole, "sound").clone();
    row["iterations"] = 12345.into();
    bench.write("out/journal.jsonl", format!("{settings}\n{row}\n{{\"case\": \"cut off"));
    let again = report(&bench, 1.0, &[]).expect(0).json();
    assert_eq!(self::row(&again, "sound")["iterations"], 12345, "taken over");
    assert_ne!(self::row(&again, "too soft")["iterations"], 12345, "measured");
    bench.write("out/journal.jsonl", format!("{settings}\n{row}\n"));
    let anew = report(&bench, 1.0, &["--fresh"]).expect(0).json();
    assert_ne!(self::row(&anew, "sound")["iterations"], 12345, "measured anew");
}

#[test]
fn what_makes_no_sense_is_refused_with_what_would() {
    let bench = Bench::new();
    report(&bench, 1.0, &["--case", "no-such-case"]).expect(2).says(&["no-such-case", "allowed is a part of bar"]);
    report(&bench, 1.0, &["--baseline", "cases/bar.toml"])
        .expect(2)
        .says(&["cases/bar.toml", "allowed is a report.json"]);
    bench.write("cases/catalogue.toml", "[[case]]\nname = \"x\"\n");
    let args = ["report", "accuracy", "--catalogue", "cases/catalogue.toml", "-q", "--out", "out"];
    bench.pliant(&args).expect(2).says(&["catalogue", "missing field"]);
    bench.pliant(&["report", "accuracy", "--scene", "nowhere.toml", "-q"]).expect(2).says(&["nowhere.toml"]);
}

#[test]
fn a_scene_of_ones_own_converges_to_its_own_refined_solution() {
    let bench = Bench::new();
    let scene = SCENE.replace(
        "faulty-plugins#sound-springs\"",
        "mass-spring\", params = { young = 1e3, density = 100, damping-time = 0.02 }",
    );
    let scene = scene.replace(
        "duration = 1\ndt = 1\nintegrator = \"quasi-static\"",
        "duration = 0.032\ndt = 0.001\nintegrator = \"backward-euler\"",
    );
    bench.write("own.toml", scene.replace("-0.02", "-9.81"));
    let ran = bench
        .pliant(&["report", "accuracy", "--scene", "own.toml", "--quick", "-q", "--json", "--out", "own"])
        .expect(0)
        .json();
    let rows = ran["rows"].as_array().expect("rows");
    let of = |method: &str| -> Vec<f64> {
        let of = rows.iter().filter(|r| r["method"] == method && r["case"] == "own: surface at the end");
        of.map(|r| r["error"].as_f64().unwrap_or(f64::NAN)).collect()
    };
    let steps = of("backward-euler");
    assert!(steps.len() == 3 && steps.windows(2).all(|e| e[1] < 0.6 * e[0]), "finer steps are nearer: {steps:?}");
    let solver = of("backward-euler, solver");
    let own = steps[2];
    assert!(solver.first() > solver.last(), "{solver:?}");
    assert!(solver.last().is_some_and(|e| (e / own - 1.0).abs() < 1e-3), "a step's error stays: {solver:?}, {own}");
    assert!(bench.names("own").iter().any(|n| n.ends_with("work.svg")));
}

/// A strip that falls freely for 32 ms, so soft that no integrator needs substeps.
const FALLING: &str = r#"format = 1
gravity = [0, -9.81, 0]
[time]
duration = 0.032
dt = 0.001
integrator = "backward-euler"
[solver]
tolerance = 1e-8
[[body]]
name = "strip"
shape = { kind = "sheet", cells = 2, rows = 4, size = [0.025, 0.05, 0], pattern = "regular" }
sheet = { warp = [1, 0, 0] }
[body.material]
plugin = "cloth"
params = { density = 0.2, young-warp = 0.05, poisson = 0, bending = "none", damping-time = 0 }
"#;

/// Steps (s) and errors of the surface of a series.
fn surface_errors(rows: &[Value], method: &str) -> Vec<(f64, f64)> {
    let of = rows.iter().filter(|r| r["method"] == method && r["case"] == "falling: surface at the end");
    of.map(|r| (r["dt"].as_f64().expect("s"), r["error"].as_f64().expect("an error"))).collect()
}

#[test]
fn all_integrators_are_compared_with_one_reference_and_have_the_errors_of_free_fall() {
    let bench = Bench::new();
    bench.write("falling.toml", FALLING);
    let args = ["report", "accuracy", "--scene", "falling.toml", "-q", "--json", "--out", "out"];
    let ran = bench.pliant(&args).expect(0).json();
    assert_eq!(ran["not_run"], serde_json::json!([]), "{}", ran["not_run"]);
    let rows = ran["rows"].as_array().expect("rows");
    let reference = "time.integrator = bdf2, time.dt = 0.000125, solver.tolerance = 0.0000000001";
    assert!(rows.iter().all(|r| r["reference"] == reference), "{rows:?}");
    // From rest, both integrators of first order fall by g (t^2 + t h) / 2, the exact fall is g t^2 / 2: the error is h / t at every step h, the finest included.
    for method in ["symplectic-euler", "backward-euler"] {
        let of = surface_errors(rows, method);
        assert_eq!(of.len(), 5, "{of:?}");
        for (dt, error) in of {
            assert!((error / (dt / 0.032) - 1.0).abs() < 0.01, "{method} at {dt} s: {error}, not {}", dt / 0.032);
        }
    }
    // BDF2 begins with a step of backward Euler, whose error of g h^2 / 2 grows to three halves of it: 1.5 (h / t)^2, of the reference too.
    let of = surface_errors(rows, "bdf2");
    assert_eq!(of.len(), 5, "{of:?}");
    for (dt, error) in of {
        let expected = 1.5 * (dt * dt - 0.000_125_f64.powi(2)) / 0.032_f64.powi(2);
        assert!((error / expected - 1.0).abs() < 0.03, "bdf2 at {dt} s: {error}, not {expected}");
    }
    let page = String::from_utf8(bench.read("out/report.html")).expect("UTF-8");
    for text in ["Reference: the same scene with time.integrator = bdf2", "one run is the reference of all of them"] {
        assert!(page.contains(text), "{text}");
    }
}

#[test]
fn grids_of_other_levels_have_a_front_and_a_reference_of_their_own() {
    let bench = Bench::new();
    bench.write("block.toml", PRESSED.replace("level = 3", "level = 4").replace("duration = 0.32", "duration = 0.16"));
    let args = ["report", "accuracy", "--scene", "block.toml", "--quick", "-q", "--json", "--out", "out"];
    let ran = bench.pliant(&args).expect(0).json();
    let rows = ran["rows"].as_array().expect("rows");
    let cases = |method: &str| -> Vec<(&str, &str)> {
        let of = rows.iter().filter(|r| r["method"] == method);
        of.map(|r| (r["case"].as_str().expect("a case"), r["reference"].as_str().expect("a reference"))).collect()
    };
    for (case, reference) in cases("backward-euler, grid") {
        assert!(
            case.contains(", other grids: ") && reference.ends_with("body.0.grid.level = 5"),
            "{case}: {reference}"
        );
    }
    let own = [cases("backward-euler"), cases("backward-euler, solver")].concat();
    assert!(
        own.len() > 6 && own.iter().all(|(case, reference)| !case.contains("other") && *reference == own[0].1),
        "{own:?}"
    );
    // Each front is one of its own: no row of one is dominated by a row of the other.
    for front in ["block: surface at the end", "block, other grids: surface at the end"] {
        assert!(rows.iter().any(|r| r["case"] == front && r["front"] == true), "{front}: {rows:?}");
    }
}

/// A finger that moves 16 mm within 30 ms, 10 mm of them into a block.
const PRESSED: &str = r#"format = 1
[time]
duration = 0.32
dt = 0.01
integrator = "backward-euler"
[[body]]
shape = { kind = "box", cells = 4, size = [0.04, 0.04, 0.04] }
material = { plugin = "mass-spring" }
grid = { level = 3, region = "whole" }
[[body.fixed]]
box = [[-1, -1, -1], [1, 1, -0.0199]]
[[device]]
name = "hand"
plugin = "scripted"
params = { path = [[0.0, 0.0, 0.0, 0.03], [0.03, 0.0, 0.0, 0.014]] }
[[tool]]
name = "finger"
device = "hand"
radius = "6 mm"
[[edit]]
kind = "touch"
tool = "finger"
"#;

#[test]
fn forces_that_are_far_off_with_the_step_of_the_scene_fail_its_report() {
    let bench = Bench::new();
    bench.write("pressed.toml", PRESSED);
    let report = |dt: &str| {
        let args = ["report", "accuracy", "--scene", "pressed.toml", "--quick", "-q", "--json", "--strict", "--fresh"];
        bench.pliant(&[&args[..], &["--set", dt, "--out", "out"]].concat())
    };
    let judged = |report: &Value| -> Vec<(f64, bool)> {
        let rows = report["rows"].as_array().expect("rows").iter();
        let of_step = rows.filter(|r| r["at"].get("time.dt").is_some() && r["passed"].is_boolean());
        of_step.map(|r| (r["dt"].as_f64().expect("s"), r["passed"] == true)).collect()
    };
    assert_eq!(judged(&report("time.dt=0.01").expect(0).json()), [(0.01, true)]);
    // One step takes the finger over most of its way.
    let ran = report("time.dt=0.02").expect(1).json();
    assert_eq!(judged(&ran), [(0.02, false)]);
    let said = ran["verdict"]["missed"][0].as_str().expect("a sentence");
    assert!(said.contains("force on the hands") && said.contains("own time.dt of 0.02"), "{said}");
}
