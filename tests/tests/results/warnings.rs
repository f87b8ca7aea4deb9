//! What has no effect is said: on standard error, in the JSON and in the summary, by a code; `--strict` makes it an error.

use pliant_engine::edit::KINDS;
use pliant_tests::models::CUBE;
use pliant_tests::{Bench, Ran, box_scene, warning_codes as codes};

/// Runs `scene.toml` of a bench: the codes of its summary, which are those on standard output and on standard error.
fn run(bench: &Bench) -> Vec<String> {
    let ran: Ran = bench.pliant(&["run", "scene.toml", "--json", "--out", "out"]).expect(0);
    let found = codes(&bench.summary("out"));
    assert_eq!(codes(&ran.json()), found);
    let printed = ran.err.lines().filter(|line| line.starts_with("warning [")).count();
    assert_eq!(printed, found.len(), "{}", ran.err);
    let places = bench.summary("out")["warnings"].clone();
    assert!(places.as_array().unwrap().iter().all(|w| w["where"].as_str().unwrap().contains("scene.toml")), "{places}");
    bench.pliant(&["run", "scene.toml", "-q", "--strict", "--out", "strict"]).expect(if found.is_empty() {
        0
    } else {
        2
    });
    found
}

/// A scene of a file `model.obj` in the place of the box.
fn with_model(size: &str, fixed: &str) -> String {
    let scene = box_scene("", fixed, "");
    scene.replace(
        "shape = { kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }",
        &format!("mesh = \"model.obj\"\n{size}"),
    )
}

/// The same with a knife that goes down by `depth` (m) through the top.
fn with_knife(scene: &str, depth: f64) -> String {
    let blade = "radius = \"1 mm\"\nblade = { length = \"100 mm\", toughness = \"2 J/m^2\", direction = [1.0, 0, 0] }";
    let path = format!("path = [[0.0, -0.05, 0.0, 0.006], [0.05, -0.05, 0.0, {}]]", -depth);
    let old = "path = [[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001], [0.05, 0.002, 0.0, 0.001]]";
    scene.replace("kind = \"touch\"", "kind = \"cut\"").replace("radius = \"4 mm\"", blade).replace(old, &path)
}

#[test]
fn a_touch_and_a_cut_of_a_sound_scene_give_none() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    assert_eq!(run(&bench), [""; 0]);
    bench.write("scene.toml", with_knife(&box_scene("", "", ""), 0.01));
    assert_eq!(run(&bench), [""; 0]);
}

#[test]
fn a_cut_that_cuts_nothing_is_told() {
    let bench = Bench::new();
    bench.write("scene.toml", with_knife(&box_scene("", "", ""), -0.002));
    assert_eq!(run(&bench), ["cuts-nothing"]);
}

#[test]
fn an_edit_that_meets_nothing_is_told() {
    let bench = Bench::new();
    let far = box_scene("", "", "").replace("0.006]", "0.106]").replace("0.001]", "0.101]");
    for kind in KINDS.iter().filter(|kind| !kind.cuts()).map(|kind| kind.name()) {
        bench.write("scene.toml", far.replace("\"touch\"", &format!("\"{kind}\"")));
        assert_eq!(run(&bench), ["no-force"], "{kind}");
    }
}

#[test]
fn a_radius_that_cells_are_too_wide_for_is_told() {
    let bench = Bench::new();
    // An edge of a cell is 2.5 mm.
    for (radius, said) in [("3 mm", &["small-radius"][..]), ("4 mm", &[])] {
        let keys = format!("radius = \"{radius}\"\nsymmetry = \"x\"");
        bench.write("scene.toml", box_scene("", "", &keys).replace("\"touch\"", "\"grow\""));
        assert_eq!(run(&bench), said, "{radius}");
    }
    let coarse = "\n[[body]]\nshape = { kind = \"box\", cells = 2, size = [0.04, 0.04, 0.04] }\nposition = [0.5, 0, 0]\n\
                  material = { plugin = \"mass-spring\" }\ngrid = { level = 3 }";
    let text = box_scene("", "", &format!("radius = \"4 mm\"{coarse}"));
    bench.write("scene.toml", text.replace("\"touch\"", "\"grow\""));
    assert!(!run(&bench).contains(&"small-radius".to_owned()), "another body, which the hand does not meet, is coarse");
    bench.write("scene.toml", box_scene("", "", "").replace("\"touch\"", "\"grow\"").replace("\"4 mm\"", "\"1 mm\""));
    assert!(!run(&bench).contains(&"small-radius".to_owned()), "the default, 3 mm, asks for nothing");
}

#[test]
fn a_touch_that_moves_no_vertex_is_told_of_large_triangles_alone() {
    let bench = Bench::new();
    for (cells, said) in [(1, true), (24, false)] {
        let scene =
            box_scene("", "", "").replace("cells = 12", &format!("cells = {cells}")).replace("level = 5", "level = 6");
        bench.write("scene.toml", scene);
        assert_eq!(run(&bench).contains(&"moves-no-vertex".to_owned()), said, "{cells} cells");
    }
}

#[test]
fn a_fixed_that_holds_nothing_is_told() {
    let bench = Bench::new();
    for region in ["local", "whole"] {
        let grid = format!("grid = {{ level = 5, region = \"{region}\" }}");
        for (least, said) in [(0.9, true), (-0.03, false)] {
            let fixed = format!("fixed = [{{ box = [[{least}, -1, -1], [1, 1, 1]] }}]");
            let scene = box_scene("duration = 0.01", &fixed, "").replacen("duration = 0.05\n", "", 1);
            bench.write("scene.toml", scene.replace("grid = { level = 5 }", &grid));
            let plan = bench.pliant(&["plan", "scene.toml", "--json"]).expect(0).json();
            assert_eq!(codes(&plan), if said { vec!["fixes-nothing"] } else { vec![] }, "{region} {least}");
        }
    }
}

#[test]
fn a_model_without_a_size_is_told_where_its_cells_are_wider_than_the_tool() {
    let bench = Bench::new();
    let cube = |edge: &str| {
        CUBE.lines()
            .map(|l| if l.starts_with('v') { l.replace('1', edge) } else { l.into() } + "\n")
            .collect::<String>()
    };
    for (edge, size, said) in [
        ("400", "", true),
        ("0.0001", "", true),
        ("0.04", "", false),
        ("400", "size = \"40 mm\"", false),
        ("400", "scale = 0.0001", false),
    ] {
        bench.write("model.obj", cube(edge));
        bench.write("scene.toml", with_model(size, ""));
        let plan = bench.pliant(&["plan", "scene.toml", "--json"]).expect(0).json();
        assert_eq!(codes(&plan), if said { vec!["doubtful-units"] } else { vec![] }, "{edge} {size}");
    }
}

#[test]
fn an_open_body_under_a_blade_is_told_with_its_border_edges() {
    let bench = Bench::new();
    let open = CUBE.replace("f 5 6 7 8\n", "");
    for (model, border) in [(CUBE, 0), (open.as_str(), 4)] {
        bench.write("model.obj", model);
        bench.write(
            "scene.toml",
            with_knife(&with_model("size = \"40 mm\"", ""), 0.005)
                .replace("from = [0.45, 0.55, 2.0]", "from = [0.45, 2.0, 0.5]")
                .replace("toward = [0.45, 0.55, 0.5]", "toward = [0.45, 0.5, 0.5]"),
        );
        let plan = bench.pliant(&["plan", "scene.toml", "--json"]).expect(0).json();
        assert_eq!(plan["bodies"][0]["border_edges"], border);
        assert_eq!(codes(&plan), if border > 0 { vec!["open-body"] } else { vec![] });
        assert!(border == 0 || plan["warnings"][0]["message"].as_str().unwrap().contains("4 border edges"), "{plan}");
    }
}

#[test]
fn bodies_that_come_together_are_told() {
    let bench = Bench::new();
    let other = |at: f64| {
        let body = "[[body]]\nname = \"other\"\nshape = { kind = \"box\", cells = 4, size = [0.02, 0.02, 0.02] }\nmaterial = { plugin = \"mass-spring\" }";
        let grid = "grid = { level = 3, region = \"whole\" }";
        let text = box_scene("", "", &format!("{body}\nposition = [0.0, 0.0, {at}]\n{grid}\n"));
        // It falls by 12 mm within the run.
        text.replacen("format = 1", "format = 1\ngravity = [0, 0, -9.81]", 1)
    };
    for (at, said) in [(0.02, vec!["bodies-overlap"]), (0.0305, vec!["bodies-meet"]), (0.0605, vec![])] {
        bench.write("scene.toml", other(at));
        assert_eq!(run(&bench), said, "{at} m");
    }
}

#[test]
fn more_threads_than_processors_are_not_started_and_told() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    let processors = pliant_engine::session::processors();
    let asked = (processors + 1).to_string();
    let run = |out: &str, more: &[&str], code: i32| {
        let args = [&["run", "scene.toml", "-q", "--record", "hand.rec", "--out", out], more].concat();
        bench.pliant(&args).expect(code)
    };
    let ran = run("many", &["--threads", "1024"], 0);
    ran.says(&["[fewer-threads] scene.toml: 1024 threads are asked for", &format!("allowed is up to {processors}")]);
    let plan = bench.pliant(&["plan", "scene.toml", "--threads", &asked, "--json"]).expect(0);
    assert_eq!(plan.json()["choices"]["threads"], processors);
    for out in ["many", "strict"] {
        let expected = if out == "many" { 0 } else { 2 };
        let strict: &[&str] = if out == "many" { &[] } else { &["--strict"] };
        run(out, &[&["--threads", &asked], strict].concat(), expected).says(&["fewer-threads"]);
    }
    assert_eq!(codes(&bench.summary("many")), ["fewer-threads"]);
    assert_eq!(bench.summary("many")["choices"]["threads"], processors);
    bench
        .pliant(&["replay", "hand.rec", "-q", "--out", "again", "--threads", &asked])
        .expect(0)
        .says(&["fewer-threads"]);
    // As many as there are, and more that are meant.
    for (out, more) in [("all", &["--threads", "0"][..]), ("meant", &["--threads", &asked, "--oversubscribe"])] {
        run(out, more, 0);
        assert_eq!(codes(&bench.summary(out)), [""; 0], "{out}");
        assert!(bench.read(&format!("{out}/final.obj")) == bench.read("many/final.obj"), "{out}");
    }
    assert_eq!(bench.summary("meant")["choices"]["threads"], processors + 1);
}
