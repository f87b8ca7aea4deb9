//! The memory of a session is estimated before it is allocated: the estimate bounds what a run takes, and a scene that needs more than is
//! allowed is refused with what needs it and what would fit.

use pliant_tests::Bench;
use std::fmt::Write;

/// Largest ratio of estimate and peak memory of a body that is simulated as a whole, and of a local region. A region is estimated as half of a
/// ball, and the memory of its samples is free again when its matrix is made; the flat sides of these bodies are sampled without the
/// reserve for tilted ones.
const WHOLE: f64 = 2.5;
const LOCAL: f64 = 6.0;

/// A body that a finger presses 2 mm deep in 10 steps.
struct Press {
    shape: &'static str,
    material: &'static str,
    integrator: &'static str,
    region: &'static str,
    level: u32,
}

impl Press {
    fn scene(&self) -> String {
        let Self { shape, material, integrator, region, level } = self;
        format!(
            r#"
            format = 1
            time = {{ duration = "10 ms", dt = "1 ms", integrator = "{integrator}", force-unstable = true, most-substeps = 1000 }}
            [[body]]
            name = "b"
            shape = {{ {shape} }}
            material = {{ plugin = "{material}" }}
            grid = {{ level = {level}, region = "{region}" }}
            [[device]]
            name = "hand"
            frame = {{ body = "b", from = [0.5, 0.5, 1.5], toward = [0.5, 0.5, 0.5] }}
            params = {{ interpolation = "linear", path = [[0, 0, 0, 0], [0.01, 0, 0, -0.002]] }}
            [[tool]]
            name = "finger"
            device = "hand"
            radius = "5 mm"
            [[edit]]
            kind = "touch"
            tool = "finger"
            "#
        )
    }
}

/// Estimate and peak memory of a run, bytes. A run that ends early, because a step is beyond its limit, has allocated all before.
fn measured(scene: &str) -> Option<(f64, f64)> {
    let bench = Bench::new();
    bench.write("scene.toml", scene);
    let planned = bench.pliant(&["plan", "scene.toml", "--json"]).expect(0).json();
    let run = bench.pliant(&["run", "scene.toml", "--json", "--out", "out"]);
    let peak = run.json()["peak_memory"].as_f64()?;
    Some((planned["memory"].as_f64()?, peak))
}

#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "the peak memory of a program is read from /proc")]
fn the_estimate_bounds_the_memory_of_a_run_from_above_and_not_by_much() {
    let shapes = [
        r#"kind = "box", size = [0.1, 0.1, 0.1], cells = 8"#,
        r#"kind = "box", size = [0.1, 0.06, 0.02], cells = 16"#,
        r#"kind = "sphere", size = [0.1, 0.1, 0.1], cells = 40"#,
        r#"kind = "cylinder", size = [0.03, 0.03, 0.1], cells = 12"#,
    ];
    let mut told = String::new();
    for (i, shape) in shapes.into_iter().enumerate() {
        for (region, levels) in [("whole", [4, 6]), ("local", [5, 7])] {
            for (j, level) in levels.into_iter().enumerate() {
                let material = ["mass-spring", "neo-hookean", "corotational"][(i + j) % 3];
                for integrator in ["symplectic-euler", "backward-euler"] {
                    let press = Press { shape, material, integrator, region, level };
                    let (estimate, peak) = measured(&press.scene()).expect("plan and run tell their memory");
                    let most = if region == "whole" { WHOLE } else { LOCAL };
                    let held = peak <= estimate && estimate <= most * peak;
                    let row =
                        format!("{shape} {material} {integrator} {region} {level}: {estimate:.3e} for {peak:.3e} B");
                    writeln!(told, "{} {row}", if held { "held  " } else { "FAILED" }).unwrap();
                }
            }
        }
    }
    assert!(!told.contains("FAILED"), "\n{told}");
}

#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "the peak memory of a program is read from /proc")]
fn the_estimate_of_a_sheet_bounds_its_memory() {
    for (cells, integrator) in [(30, "backward-euler"), (120, "symplectic-euler"), (120, "backward-euler")] {
        let scene = format!(
            r#"
            format = 1
            gravity = [0, 0, -9.81]
            time = {{ duration = "4 ms", dt = "2 ms", integrator = "{integrator}", force-unstable = true, most-substeps = 100000 }}
            [[body]]
            name = "b"
            shape = {{ kind = "sheet", size = [1, 1, 0], cells = {cells} }}
            sheet = {{}}
            material = {{ plugin = "cloth" }}
            "#
        );
        let (estimate, peak) = measured(&scene).expect("plan and run tell their memory");
        assert!(peak <= estimate && estimate <= WHOLE * peak, "{cells} {integrator}: {estimate:e} for {peak:e} B");
    }
}

#[test]
fn a_level_that_needs_too_much_is_refused_with_one_that_fits() {
    let shape = r#"kind = "box", size = [0.1, 0.1, 0.1], cells = 8"#;
    let press =
        |region, level| Press { shape, material: "mass-spring", integrator: "backward-euler", region, level }.scene();
    let bench = Bench::new();
    bench.write("scene.toml", press("whole", 7));
    for verb in ["plan", "run"] {
        let ran = bench.pliant(&[verb, "scene.toml", "--memory", "800 MB"]).expect(2);
        ran.says(&[
            "scene.toml:",
            "body `b` needs about",
            "cells of level 7",
            "allowed is 800.0 MB",
            "use level 6",
            "--memory",
        ]);
    }
    // The level that is named is within the budget.
    bench.write("scene.toml", press("whole", 6));
    let plan = bench.pliant(&["plan", "scene.toml", "--memory", "800 MB", "--json"]).expect(0).json();
    assert!(plan["memory"].as_u64().is_some_and(|bytes| (1..=800_000_000).contains(&bytes)), "{plan}");
    bench.pliant(&["plan", "scene.toml", "--memory", "20"]).expect(2).says(&["allowed is a number above 0 with B, kB"]);
    // By default the budget is the machine's: level 10 of a whole body would need 600 GB.
    bench.write("scene.toml", press("whole", 10));
    bench.pliant(&["plan", "scene.toml"]).expect(2).says(&["cells of level 10", "this machine's memory", "use level"]);
}

#[test]
fn models_and_shapes_are_checked_before_they_are_read() {
    let shape = r#"kind = "sphere", size = [0.1, 0.1, 0.1], cells = 4096"#;
    let press = Press { shape, material: "mass-spring", integrator: "auto", region: "local", level: 5 };
    let bench = Bench::new();
    bench.write("scene.toml", press.scene());
    let ran = bench.pliant(&["plan", "scene.toml", "--memory", "2 GB"]).expect(2);
    ran.says(&["scene.toml:5:", "body `b`", "a shape of 4096 cells along an edge", "allowed is 2.00 GB"]);

    // A file of 30 MB is refused by its size alone: it holds no model.
    bench.write("model.obj", vec![b'#'; 30_000_000]);
    bench.write("scene.toml", press.scene().replace(&format!("shape = {{ {shape} }}"), "mesh = \"model.obj\""));
    bench
        .pliant(&["plan", "scene.toml", "--memory", "100 MB"])
        .expect(2)
        .says(&["model.obj of 30.0 MB", "needs about 90.0 MB"]);
    let small = press.scene().replace("cells = 4096", "cells = 8");
    bench.write("scene.toml", format!("{small}\n[[obstacle]]\nname = \"rock\"\nmesh = \"model.obj\"\n"));
    bench
        .pliant(&["plan", "scene.toml", "--memory", "100 MB"])
        .expect(2)
        .says(&["obstacle `rock` needs about 90.0 MB", "model.obj of 30.0 MB"]);

    let sheet = scene_of_sheet(r#"kind = "sheet", size = [1, 1, 0], cells = 300"#);
    bench.write("scene.toml", sheet);
    bench.pliant(&["plan", "scene.toml", "--memory", "200 MB"]).expect(2).says(&["a sheet of 180000 triangles"]);
}

/// A falling sheet of this shape.
fn scene_of_sheet(shape: &str) -> String {
    format!(
        "format = 1\ngravity = [0, 0, -9.81]\ntime = {{ duration = \"4 ms\", dt = \"2 ms\" }}\n[[body]]\nname = \"b\"\n\
         shape = {{ {shape} }}\nsheet = {{}}\nmaterial = {{ plugin = \"cloth\" }}\n"
    )
}

#[test]
fn many_small_bodies_are_summed() {
    let body = |i: usize| {
        format!(
            "[[body]]\nname = \"b{i}\"\nshape = {{ kind = \"box\", size = [0.1, 0.1, 0.1], cells = 2 }}\nmaterial = {{ plugin = \"mass-spring\" }}\n\
             grid = {{ level = 4, region = \"whole\" }}\n"
        )
    };
    let bodies: String = (0..30).map(body).collect();
    let time = "format = 1\ngravity = [0, 0, -9.81]\ntime = { duration = \"2 ms\", dt = \"1 ms\" }\n";
    let bench = Bench::new();
    bench.write("scene.toml", format!("{time}{bodies}"));
    let ran = bench.pliant(&["plan", "scene.toml", "--memory", "60 MB"]).expect(2);
    ran.says(&["body `b", "MB are taken before it", "allowed is 60.0 MB"]);
    bench.pliant(&["plan", "scene.toml", "--memory", "1 GB"]).expect(0);
}

#[test]
fn a_region_that_outgrows_the_budget_freezes_its_body() {
    // A long stroke over a body that takes long to come back to rest keeps all cells it has passed.
    let press = Press {
        shape: r#"kind = "box", size = [0.3, 0.03, 0.03], cells = 16"#,
        material: "mass-spring",
        integrator: "backward-euler",
        region: "local",
        level: 7,
    };
    let scene = press.scene().replace("[0.01, 0, 0, -0.002]", "[0.01, 0, 0, -0.002], [0.06, 0.13, 0, -0.002]");
    let scene = scene.replace("duration = \"10 ms\"", "duration = \"60 ms\"");
    let scene = scene.replace("region = \"local\"", "region = \"local\", radius = \"6 mm\", relaxation = \"10 s\"");
    let scene = scene.replace("radius = \"5 mm\"", "radius = \"5 mm\"\nspeed = \"10 m/s\"");
    let bench = Bench::new();
    bench.write("scene.toml", &scene);
    let needed = bench.pliant(&["plan", "scene.toml", "--json"]).expect(0).json()["memory"].as_u64().unwrap();
    bench.pliant(&["run", "scene.toml", "--out", "free"]).expect(0);
    let budget = format!("{} B", needed + 1);
    bench.pliant(&["run", "scene.toml", "--out", "held", "--memory", &budget]).says(&["a region of", "allowed is"]);
}
