//! `pliant report stability` can come out bad: a material that makes energy and an integrator that gains some are told.

use pliant_tests::Bench;
use serde_json::Value;

/// A block of springs that hangs from its top and is let go.
const SCENE: &str = r#"format = 1
gravity = [0, 0, -1.0]
[time]
duration = 0.5
dt = 1e-3
integrator = "symplectic-euler"
[[body]]
shape = { kind = "box", cells = 4, size = [0.04, 0.04, 0.04] }
material = { plugin = "faulty-plugins#sound-springs" }
grid = { level = 3, region = "whole" }
[[body.fixed]]
box = [[-1, -1, 0.0199], [1, 1, 1]]
"#;

const CATALOGUE: &str = r#"
[[map]]
name = "springs"
title = "springs by their step"
scene = "block"
along = "gravity (m/s^2)"
point = [{ value = 1.0, set = { gravity = [0, 0, -1.0] } }]
step = [1e-3, 1e-2]
steps = 300
integrator = ["symplectic-euler", "explicit-euler"]
limit = true

[[balance]]
name = "sound"
title = "springs"
scene = "block"
of = "energy"
tolerance = 0.05
integrator = ["symplectic-euler"]

[[balance]]
name = "gains"
title = "springs whose damping pushes"
scene = "block"
of = "energy"
tolerance = 0.05
integrator = ["symplectic-euler"]
set = { "body.0.material.plugin" = "faulty-plugins#damping-gains" }

[[extreme]]
name = "asked to be refused, and is not"
scene = "block"
set = {}
expect = "refused"

[[extreme]]
name = "no step"
scene = "block"
set = { "time.dt" = 0 }
expect = "refused"
says = "allowed"
"#;

#[test]
fn what_makes_energy_is_told_from_what_does_not() {
    let bench = Bench::new();
    bench.write("cases/block.toml", SCENE);
    bench.write("cases/catalogue.toml", CATALOGUE);
    let args = ["report", "stability", "--catalogue", "cases/catalogue.toml", "-q", "--json", "--out", "out"];
    let ran = bench.pliant(&args).expect(0).json();
    let rows = ran["rows"].as_array().expect("rows");
    let of =
        |case: &str| -> &Value { rows.iter().find(|r| r["case"] == case).unwrap_or_else(|| panic!("{case}: {ran}")) };
    assert_eq!((&of("sound")["passed"], &of("gains")["passed"]), (&true.into(), &false.into()), "{ran}");
    assert_eq!(of("gains")["state"], "growing");
    let state = |method: &str, dt: f64| {
        let row = rows.iter().find(|r| r["case"] == "springs" && r["method"] == method && r["dt"] == dt);
        row.unwrap_or_else(|| panic!("{method} {dt}"))["state"].as_str().unwrap_or_default().to_owned()
    };
    assert_eq!(state("symplectic-euler", 1e-3), "damped", "its springs are");
    assert_eq!(state("symplectic-euler", 1e-2), "growing", "over its limit");
    let limit =
        rows.iter().find(|r| r["case"] == "limit-springs" && r["method"] == "symplectic-euler").expect("a limit");
    assert!(limit["found"]["ratio"].as_f64().is_some_and(|r| (0.999..1.25).contains(&r)), "{limit}");
    let extreme = |name: &str| &rows.iter().find(|r| r["method"] == name).expect("a row")["passed"];
    assert_eq!(extreme("asked to be refused, and is not"), &false);
    assert_eq!(extreme("no step"), &true);
    let missed = ran["verdict"]["missed"].as_array().expect("a list");
    assert!(missed.iter().any(|m| m.as_str().is_some_and(|m| m.starts_with("gains"))), "{missed:?}");
    bench.pliant(&[&args[..], &["--strict"]].concat()).expect(1);
    let page = String::from_utf8(bench.read("out/report.html")).expect("UTF-8");
    for part in ["Coupling of hand and surface", "The extreme catalogue", "step (s)", "gravity (m/s^2)"] {
        assert!(page.contains(part), "{part}");
    }
    // No hand may fail below the bound of Colgate and Schenkel.
    let coupled: Vec<&Value> = rows.iter().filter(|r| r["case"] == "coupling").collect();
    assert!(coupled.len() > 20 && coupled.iter().all(|r| r["passed"] == true), "{coupled:?}");
}
