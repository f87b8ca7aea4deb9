//! `level = "auto"`: cells that suit the tool, within a number of cells.

use pliant_tests::{Bench, box_scene};
use serde_json::Value;

/// A scene of a box of this size (m) under a ball of this radius (m).
fn scene(size: [f64; 3], radius: f64, grid: &str) -> String {
    box_scene("", "", "")
        .replace("size = [0.04, 0.04, 0.04]", &format!("size = {size:?}"))
        .replace("grid = { level = 5 }", &format!("grid = {{ {grid} }}"))
        .replace("radius = \"4 mm\"", &format!("radius = {radius:?}"))
}

fn plan(bench: &Bench, text: String) -> Value {
    bench.write("scene.toml", text);
    bench.pliant(&["plan", "scene.toml", "--json"]).expect(0).json()
}

#[test]
fn the_cells_that_are_planned_are_those_that_were_estimated() {
    let bench = Bench::new();
    let mut limited = 0;
    for size in [[0.04, 0.04, 0.04], [0.1, 0.02, 0.03], [0.2, 0.2, 0.01], [0.3, 0.1, 0.1]] {
        for (radius, region) in [(0.02, ""), (0.004, ""), (0.004, "region = \"whole\""), (0.0015, "region = \"whole\"")]
        {
            let what = format!("{size:?} {radius} {region}");
            let report = plan(&bench, scene(size, radius, region));
            let (choice, body) = (&report["choices"]["levels"][0], &report["bodies"][0]);
            let (level, edge) = (body["level"].as_u64().unwrap(), body["edge"].as_f64().unwrap());
            assert_eq!(choice["level"], level, "{what}");
            let suits = edge <= 0.5 * radius * (1.0 + 1e-5);
            // The cost is of the region of a tool, or of the whole body; a lattice has at most a layer of nodes more than cells on each side.
            let elements = |report: &Value| report["step_cost"][0]["nodes"].as_f64().unwrap();
            assert!(elements(&report) < 2.0 * 8000.0, "{what}: {report}");
            if !suits && level < 8 {
                limited += 1;
                let separator = if region.is_empty() { "" } else { ", " };
                let finer = plan(&bench, scene(size, radius, &format!("level = {}{separator}{region}", level + 1)));
                assert!(elements(&finer) > 0.7 * 8000.0, "{what}: {choice} {}", elements(&finer));
                assert_eq!(finer["choices"]["levels"], Value::Array(vec![]), "{what}");
            }
        }
    }
    assert!(limited > 2, "{limited} at the limit");
}

#[test]
fn a_level_is_a_whole_number_from_1_or_auto() {
    let bench = Bench::new();
    for bad in ["0", "-3", "2.5", "\"fine\"", "4294967296"] {
        bench.write("scene.toml", scene([0.04; 3], 0.004, &format!("level = {bad}")));
        bench.pliant(&["plan", "scene.toml"]).expect(2).says(&["scene.toml:", "a whole number from 1, or \"auto\""]);
    }
    let explicit = plan(&bench, scene([0.04; 3], 0.004, "level = \"auto\""));
    assert_eq!(explicit["choices"]["levels"], plan(&bench, scene([0.04; 3], 0.004, ""))["choices"]["levels"]);
}
