//! `pliant report performance` notices what became slow, and says what a step costs with all that a reader needs.

use pliant_tests::Bench;
use serde_json::Value;

const SCENE: &str = r#"format = 1
gravity = [0, 0, -1.0]
[time]
duration = 0.03
dt = 1e-3
integrator = "symplectic-euler"
[[body]]
shape = { kind = "box", cells = 4, size = [0.04, 0.04, 0.04] }
material = { plugin = "faulty-plugins#sound-springs" }
grid = { level = 3, region = "whole" }
[[body.fixed]]
box = [[-1, -1, 0.0199], [1, 1, 1]]
"#;

fn catalogue(material: &str) -> String {
    format!(
        r#"
        [[sweep]]
        name = "springs"
        title = "a block of springs"
        scene = "block"
        method = "springs, symplectic Euler"
        set = {{ "body.0.material.plugin" = "faulty-plugins#{material}" }}
        quick = 2
        threads = [1]
        growth = 1.0
        place = [
            {{ n = 4, set = {{ "body.0.grid.level" = 3 }} }},
            {{ n = 8, set = {{ "body.0.grid.level" = 4 }} }},
        ]
        [[pair]]
        name = "energies"
        scene = "block"
        set = {{ "output.energy" = false }}
        on = {{ "output.energy" = true }}
        "#
    )
}

fn report(bench: &Bench, material: &str, out: &str, more: &[&str]) -> pliant_tests::Ran {
    bench.write("cases/block.toml", SCENE);
    bench.write("cases/catalogue.toml", catalogue(material));
    let args =
        ["report", "performance", "--catalogue", "cases/catalogue.toml", "--quick", "-q", "--json", "--out", out];
    bench.pliant(&[&args[..], more].concat())
}

#[test]
fn a_material_that_became_slow_is_a_regression() {
    let bench = Bench::new();
    let first = report(&bench, "sound-springs", "before", &[]).expect(0).json();
    let rows = first["rows"].as_array().expect("rows");
    for row in rows.iter().filter(|r| r["case"] == "springs") {
        for key in ["step_seconds_median", "step_seconds_p99", "spread", "cpu_seconds"] {
            assert!(row[key].as_f64().is_some_and(f64::is_finite), "{key} in {row}");
        }
        for key in ["nodes", "integration (s)", "model (flop a step)", "model (bytes)"] {
            assert!(row["found"][key].as_f64() > Some(0.0), "{key} in {row}");
        }
        assert!(row["step_seconds_p99"].as_f64() >= row["step_seconds_median"].as_f64(), "{row}");
    }
    let has = |case: &str| rows.iter().any(|r| r["case"] == case);
    assert!(has("growth: springs") && has("left-out: energies") && has("start-up"), "{first}");
    // Each call sleeps 2 ms: several times what a step takes.
    let slow =
        report(&bench, "slow", "after", &["--baseline", "before/report.json", "--margin", "0.5"]).expect(1).json();
    let worse: Vec<&Value> = slow["baseline"]["regressions"].as_array().expect("a list").iter().collect();
    assert!(worse.iter().any(|r| r["what"] == "step_seconds_median"), "{worse:?}");
    let page = String::from_utf8(bench.read("after/report.html")).expect("UTF-8");
    for part in ["What was left out, and what it saved", "median of a step (s)", "share of a step (%)"] {
        assert!(page.contains(part), "{part}");
    }
}
