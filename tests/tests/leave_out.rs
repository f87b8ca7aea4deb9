//! What a scene does not need is not there: not opened, not mapped, not in the step; and plan and summary say so.

use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{Options, Session};
use pliant_host::SearchPath;
use pliant_tests::{Bench, box_scene, program, root};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The two of ours that the scenes below use, and the one they never do.
const GRID: &str = "pliant_octree_grid";
const MATERIAL: &str = "pliant_mass_spring";
const NEVER: &str = "faulty_plugins";
const DEVICE: &str = "pliant_scripted";

/// Plugin libraries that the system has mapped into this process; `None` where it does not tell.
fn mapped() -> Option<Vec<String>> {
    let maps = std::fs::read_to_string("/proc/self/maps").ok()?;
    let files = maps.lines().filter_map(|line| Path::new(line.split_whitespace().last()?).file_stem()?.to_str());
    let mut stems: Vec<String> = files.map(|stem| stem.trim_start_matches("lib").to_owned()).collect();
    stems.retain(|stem| [GRID, MATERIAL, DEVICE, NEVER].contains(&stem.as_str()));
    stems.sort();
    stems.dedup();
    Some(stems)
}

fn opened(text: &str) -> Session {
    let bench = Bench::new();
    let path = bench.write("scene.toml", text);
    let (scene, source) = scene::load(&path, &[]).expect("a scene");
    let plan = Plan::new(&scene, &source).expect("a plan");
    let folder: PathBuf = std::env::current_exe().expect("a path").parent().expect("a folder").into();
    let options = Options::new(SearchPath::new(&[folder]), 1);
    Session::open(&scene, &source, plan, &options).unwrap_or_else(|e| panic!("{e}"))
}

fn loaded(session: &Session) -> Vec<String> {
    let stem = |path: &str| Path::new(path).file_stem().and_then(|s| s.to_str()).map(str::to_owned);
    let mut stems: Vec<String> = session.inputs.loaded.iter().filter_map(|l| stem(&l.path)).collect();
    stems.iter_mut().for_each(|s| *s = s.trim_start_matches("lib").to_owned());
    stems.sort();
    stems
}

/// A body that nothing touches, one that gravity moves, and a hand without a tool that is a plugin of another library.
fn falling(edit: &str) -> String {
    let text = box_scene("", "", "").replace("[[edit]]\nkind = \"touch\"\ntool = \"finger\"\n", edit);
    let text = text.replace("level = 5", "level = 4, region = \"whole\"");
    text.replace("[time]", "gravity = [0, 0, -9.81]\n[time]")
}

/// In one test, in this order: what was mapped once stays mapped.
#[test]
fn a_library_is_mapped_when_a_scene_needs_it_and_not_before() {
    let sees = mapped().is_some();
    let expect = |stems: &[&str], session: Option<&Session>, what: &str| {
        let stems: Vec<String> = stems.iter().map(|s| (*s).to_owned()).collect();
        if let Some(now) = mapped() {
            assert_eq!(now, stems, "{what}: mapped");
        }
        if let Some(session) = session {
            assert_eq!(loaded(session), stems, "{what}: the host's list");
        }
    };
    expect(&[], None, "before any scene");
    let idle = opened(&falling("").replace("gravity = [0, 0, -9.81]\n", ""));
    expect(&[], Some(&idle), "nothing acts");
    assert_eq!(idle.choices.integrator, "none");

    let mut alone = opened(&falling(""));
    expect(&[MATERIAL, GRID], Some(&alone), "gravity, and a hand that does nothing");
    let device = alone.plan().left_out.iter().find(|l| l.what.contains("device `hand` (plugin `scripted`)"));
    assert!(device.is_some_and(|l| l.why.contains("no tool in use has it")), "{:?}", alone.plan().left_out);
    (0..5).for_each(|_| alone.step());
    alone.update_surface();
    expect(&[MATERIAL, GRID], Some(&alone), "after steps");

    let touched = opened(&falling("[[edit]]\nkind = \"touch\"\ntool = \"finger\"\n"));
    expect(&[MATERIAL, GRID, DEVICE], Some(&touched), "a hand that touches");

    // The check can fail: the library that no scene named is seen as soon as one does.
    let _ = pliant_tests::library(NEVER.replace('_', "-").as_str());
    assert!(!sees || mapped().is_some_and(|now| now.iter().any(|stem| stem == NEVER)));
}

#[test]
fn a_device_that_cannot_be_opened_harms_nothing_if_no_edit_uses_it() {
    let bench = Bench::new();
    let broken = bench.write("plugins/libbroken.so", "no library at all");
    let text =
        falling("").replace("name = \"hand\"", &format!("name = \"hand\"\nplugin = {:?}", broken.to_str().unwrap()));
    bench.write("scene.toml", text);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    let edit = "edit=[{ kind = \"touch\", tool = \"finger\" }]";
    let run = ["run", "scene.toml", "-q", "--out", "other", "--set", edit];
    bench.pliant(&run).expect(2).says(&["libbroken.so", "--allow-plugins"]);
    bench.pliant(&[&run[..], &["--allow-plugins", "plugins"]].concat()).expect(3).says(&["libbroken.so"]);
}

/// What is left out and why, of a document.
fn list(document: &Value) -> Vec<(String, String)> {
    let text = |l: &Value, key: &str| l[key].as_str().expect("text").to_owned();
    let all = document["left_out"].as_array().expect("a list");
    all.iter().map(|l| (text(l, "what"), text(l, "why"))).collect()
}

fn has(list: &[(String, String)], what: &str) -> bool {
    list.iter().any(|(w, why)| w.contains(what) && !why.is_empty())
}

#[test]
fn plan_and_summary_list_the_same_and_plan_says_it_in_words() {
    let bench = Bench::new();
    for (text, there, left) in [
        (
            box_scene("integrator = \"symplectic-euler\"", "", ""),
            &[][..],
            &["gravity", "matrix and linear solver", "levels 6 and finer", "damping in the coupling", "pictures"][..],
        ),
        (
            box_scene("integrator = \"backward-euler\"", "", "[output]\nenergy = false\ntrace = false\nframes = 20"),
            &["matrix and linear solver", "pictures"],
            &["energies", "gravity"],
        ),
        (falling(""), &["gravity"], &["contact, coupling and force safety", "tool `finger`", "device `hand`"]),
        (
            falling("").replace("-9.81", "0"),
            &[],
            &["gravity", "plugins `octree-grid` and `mass-spring` of body `block`", "integration"],
        ),
        (box_scene("", "", "").replace("[time]", "gravity = [0, 0, -9.81]\n[time]"), &[], &["gravity on body `block`"]),
        (
            box_scene("", "", "").replace("radius = \"4 mm\"", "radius = \"4 mm\"\nfriction = [0, 0]"),
            &[],
            &["friction"],
        ),
    ] {
        bench.write("scene.toml", &text);
        let plan = list(&bench.pliant(&["plan", "scene.toml", "--json"]).expect(0).json());
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
        let summary = bench.summary("out");
        assert_eq!(plan, list(&summary), "plan and summary");
        for what in left {
            assert!(has(&plan, what), "`{what}` is not left out of {plan:?} in\n{text}");
        }
        for what in there {
            assert!(!has(&plan, what), "`{what}` is left out of {plan:?} in\n{text}");
        }
        let words = bench.pliant(&["plan", "scene.toml"]).expect(0).out;
        for (what, why) in &plan {
            assert!(words.contains(&format!("  {what}: {why}")), "{what} is not in\n{words}");
        }
        for loaded in summary["loaded"].as_array().expect("a list") {
            assert!(words.contains(loaded["path"].as_str().expect("a path")), "{loaded} is not in\n{words}");
        }
    }
}

#[test]
fn there_is_no_matrix_without_an_implicit_integrator_and_no_contact_without_a_tool() {
    let explicit = opened(&box_scene("integrator = \"symplectic-euler\"", "", ""));
    let implicit = opened(&box_scene("integrator = \"backward-euler\"", "", ""));
    let matrix = |session: &Session| session.bodies.iter().any(|b| b.system.matrix.is_some());
    assert!(!matrix(&explicit) && matrix(&implicit));
    let alone = opened(&falling(""));
    assert!(alone.tools.is_empty() && alone.devices.is_empty());

    let bench = Bench::new();
    bench.write("scene.toml", box_scene("integrator = \"symplectic-euler\"", "", ""));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    assert_eq!(bench.summary("out")["iterations"], 0, "nothing was solved");
    bench.write("alone.toml", falling(""));
    bench.pliant(&["run", "alone.toml", "-q", "--out", "alone"]).expect(0);
    let head = String::from_utf8(bench.read("alone/trace.csv")).expect("UTF-8");
    assert!(head.starts_with("time_s,nodes,elements,"), "no columns of a hand: {}", head.lines().next().unwrap());
}

#[test]
fn gravity_of_zero_is_no_gravity_to_the_last_byte() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", "").replace("level = 5", "level = 4, region = \"whole\""));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "none"]).expect(0);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "zero", "--set", "gravity=[0, 0, 0]"]).expect(0);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "some", "--set", "gravity=[0, 0, -1]"]).expect(0);
    assert!(bench.read("none/nodes.csv") == bench.read("zero/nodes.csv"));
    assert!(bench.read("none/nodes.csv") != bench.read("some/nodes.csv"), "there is a difference to be seen");
    assert!(has(&list(&bench.summary("zero")), "gravity") && !has(&list(&bench.summary("some")), "gravity"));
}

#[test]
fn the_scenes_that_are_given_say_what_they_do_without() {
    let bench = Bench::new();
    for name in ["touch.toml", "pull.toml", "hertz.toml"] {
        let path = root().join("scenes").join(name);
        let plan = bench.pliant(&["plan", path.to_str().expect("UTF-8"), "--json"]).expect(0).json();
        let solver = has(&list(&plan), "matrix and linear solver");
        assert_eq!(solver, plan["choices"]["integrator"] != "backward-euler", "{name}");
        assert!(has(&list(&plan), "gravity") && has(&list(&plan), "and finer of the grid"), "{name}");
        assert_eq!(plan["loaded"].as_array().map(Vec::len), Some(3), "{name}: grid, material and device, no more");
    }
}

/// The window is a program of its own: a run maps no library that draws.
#[test]
#[cfg(target_os = "linux")]
fn a_run_maps_no_graphics_library() {
    let bench = Bench::new();
    let scene = bench.write("scene.toml", box_scene("", "", "").replace("duration = 0.05", "duration = 3600"));
    let mut run = std::process::Command::new(program())
        .args(["run", "-q", "--out"])
        .args([bench.path("out"), scene])
        .spawn()
        .expect("it starts");
    let maps = format!("/proc/{}/maps", run.id());
    // The material is the last that a run maps before its steps.
    let mapped = loop {
        assert!(run.try_wait().expect("a child").is_none(), "the run ended before its material was mapped");
        let mapped = std::fs::read_to_string(&maps).expect("its maps");
        if mapped.contains(MATERIAL) && mapped.contains(DEVICE) {
            break mapped;
        }
        std::thread::yield_now();
    };
    run.kill().and_then(|()| run.wait()).expect("it ends");
    for library in ["libGL", "libEGL", "libOpenGL", "libX11", "libwayland", "libxkbcommon", "libvulkan"] {
        assert!(!mapped.contains(library), "{library} is mapped");
    }
}
