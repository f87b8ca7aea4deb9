//! A plugin that goes wrong is told with its file, the reason and where the host looked; the rest goes on.

use pliant_tests::native::file_name;
use pliant_tests::{Bench, Ran, box_scene, library};
use serde_json::Value;

/// Finger, springs and grid of the faulty library, by their ids, in a scene of 0.03 s.
fn scene(material: &str, grid: &str, device: &str) -> String {
    let text = box_scene("", "", "").replace("duration = 0.05", "duration = 0.03");
    let text = text.replace("\"mass-spring\"", &format!("\"faulty-plugins#{material}\""));
    let text = text.replace("level = 5", &format!("plugin = \"faulty-plugins#{grid}\", level = 3"));
    let from = text.find("params = { path").expect("a path");
    let to = from + text[from..].find('\n').expect("a line");
    text.replace(&text[from..to], &format!("plugin = \"faulty-plugins#{device}\""))
}

const SOUND: [&str; 3] = ["sound-springs", "sound-brick", "sound-finger"];

fn run(bench: &Bench, [material, grid, device]: [&str; 3], sets: &[&str]) -> Ran {
    bench.write("scene.toml", scene(material, grid, device));
    let mut args = vec!["run", "scene.toml", "-q", "--out", "out"];
    sets.iter().for_each(|set| args.extend(["--set", set]));
    bench.pliant(&args)
}

/// Times and texts of the events that hold all of `said`.
fn events(summary: &Value, said: &[&str]) -> Vec<(f64, String)> {
    let all = summary["events"].as_array().expect("a list").iter();
    let all = all.map(|e| (e["time"].as_f64().expect("s"), e["text"].as_str().expect("text").to_owned()));
    all.filter(|(_, text)| said.iter().all(|part| text.contains(part))).collect()
}

#[test]
fn the_plugins_the_faults_are_compared_with_are_sound() {
    let bench = Bench::new();
    run(&bench, SOUND, &[]).expect(0);
    let summary = bench.summary("out");
    assert_eq!(summary["event_counts"], serde_json::json!({}), "{summary}");
    assert!(summary["contact_steps"].as_u64() > Some(20) && summary["largest_force"].as_f64() > Some(0.01));
    bench.is_finite("out", "sound");
}

#[test]
fn a_plugin_that_fails_when_it_is_opened_ends_the_run_before_it_begins() {
    let file = file_name("faulty_plugins");
    let [material, grid, device] = SOUND;
    for (plugins, said) in [
        (["panics-in-new", grid, device], &["panics-in-new", "activate", "panicked on purpose, in new"][..]),
        (["refuses-in-rest", grid, device], &["body `block`", "refuses-in-rest", "rest", "refused on purpose"]),
        (["unknown-elements", grid, device], &["unknown-elements", "elements", "unknown element kind 99"]),
        (
            ["no-mass", grid, device],
            &["body `block`", "no-mass", "node 0 at [", "mass 0 kg", "allowed is a finite mass"],
        ),
        (["lists-fail", grid, device], &["lists-fail", "elements", "can fail", "whole lists"]),
        ([material, "panics-in-build", device], &["panics-in-build", "build", "panicked on purpose, in build"]),
        ([material, "refuses-in-build", device], &["refuses-in-build", "build", "refused on purpose"]),
        (
            [material, "descending-ids", device],
            &["body `block`", "descending-ids", "region", "ids of nodes or cells are not in ascending order"],
        ),
        (
            [material, "weights-not-a-number", device],
            &["body `block`", "weights-not-a-number", "weights", "not finite"],
        ),
        ([material, "link-to-nowhere", device], &["link-to-nowhere", "region", "joins nodes [0, 1073741824] of 125"]),
        (["not-there", grid, device], &["no material `not-there` in this library; it has", "material `sound-springs`"]),
        ([material, "not-there", device], &["no grid `not-there` in this library; it has", "grid `sound-brick`"]),
        (
            [material, grid, "sound-springs"],
            &["no device `sound-springs` in this library; it has", "device `sound-finger`"],
        ),
    ] {
        let bench = Bench::new();
        let ran = run(&bench, plugins, &[]).expect(3).says(&["error: ", &file]).says(said);
        assert!(!ran.err.contains("RUST_BACKTRACE"), "{plugins:?}: {}", ran.err);
        assert_eq!(bench.names("."), ["scene.toml"], "{plugins:?}: nothing was written");
        let plan = bench.pliant(&["plan", "scene.toml", "--json"]).expect(3).json();
        assert!(said.iter().all(|part| plan["error"].as_str().is_some_and(|e| e.contains(part))), "{plan}");
    }
}

#[test]
fn a_material_that_fails_on_the_way_stops_its_body_and_is_told() {
    let file = file_name("faulty_plugins");
    let [_, grid, device] = SOUND;
    for integrator in ["symplectic-euler", "backward-euler"] {
        let set = format!("time.integrator={integrator}");
        for (plugins, said, at) in [
            (["panics-in-forces", grid, device], &[&*file, "forces", "panicked on purpose, in forces"][..], 0.01),
            (["forces-not-a-number", grid, device], &[&*file, "forces", "the result for node", "is not finite"], 0.01),
            (["blows-up", grid, device], &["not finite"], 0.01),
        ] {
            let what = format!("{plugins:?}, {integrator}");
            let bench = Bench::new();
            run(&bench, plugins, &[&set]).expect(3);
            let summary = bench.summary("out");
            let faulty = plugins.iter().find(|p| !SOUND.contains(p)).expect("one that fails");
            let told = events(&summary, &["body `block` stands still"]);
            assert!(told.len() == 1 && said.iter().all(|part| told[0].1.contains(part)), "{what}: {told:?}");
            assert!(said.len() == 1 || told[0].1.contains(faulty), "{what}: names it: {told:?}");
            assert!(told[0].0 >= at, "{what}: {told:?}");
            assert_eq!(summary["event_counts"]["quarantine"], 1, "{what}: once");
            assert!(summary["bodies"][0]["frozen"].as_str().is_some_and(|why| told[0].1.ends_with(why)), "{what}");
            assert_eq!(summary["steps"], 30, "{what}: the run went on");
            bench.is_finite("out", &what);
        }
    }
}

#[test]
fn a_device_that_fails_is_lost_and_one_that_gives_nonsense_is_let_go() {
    let file = file_name("faulty_plugins");
    let [material, grid, _] = SOUND;
    for (device, said, code) in [
        ("panics-in-read", "panicked on purpose, in read", 3),
        ("lost-in-read", "unplugged on purpose", 3),
        ("positions-not-a-number", "", 0),
    ] {
        let bench = Bench::new();
        // 50 ms after the last good sample the hand is let go.
        let bodies = ["body.0.material.plugin=mass-spring", "body.0.grid={ level = 5 }"];
        run(&bench, [material, grid, device], &[bodies[0], bodies[1], "time.duration=0.1"]).expect(code);
        let summary = bench.summary("out");
        if code == 3 {
            let told = events(&summary, &[device, &file, "read", said]);
            assert_eq!((told.len(), &summary["event_counts"]["device-lost"]), (1, &Value::from(1)), "{summary}");
        } else {
            assert!(summary["event_counts"].get("device-lost").is_none());
        }
        let told = events(&summary, &["hand of tool `finger`", "device `hand`", device, "not valid or not finite"]);
        assert!(!told.is_empty() && summary["event_counts"]["sample-dropped"].as_u64() > Some(80), "{summary}");
        let trace = String::from_utf8(bench.read("out/trace.csv")).expect("UTF-8");
        let touches: Vec<bool> = trace.lines().skip(1).map(|row| row.contains(",touch,")).collect();
        assert!(touches[10..55].iter().all(|t| *t), "{device}: the last good sample stands for 50 ms: {touches:?}");
        assert!(touches[65..].iter().all(|t| !*t), "{device}: then the hand is let go: {touches:?}");
        let force = |row: &str| row.split(',').nth(12).and_then(|c| c.parse::<f64>().ok()).expect("N").abs();
        assert!(trace.lines().last().is_some_and(|row| force(row) == 0.0), "{device}: nothing is felt");
        bench.is_finite("out", device);
    }
}

#[test]
fn what_one_plugin_does_wrong_changes_nothing_for_the_others() {
    // Beside the block that is touched another falls, by a material of its own; and a second hand touches nothing.
    let beside = |material: &str, device: &str| {
        let body = format!(
            "[[body]]\nname = \"beside\"\nshape = {{ kind = \"box\", cells = 4, size = [0.02, 0.02, 0.02] }}\n\
             position = [0.2, 0, 0]\nmaterial = {{ plugin = \"faulty-plugins#{material}\" }}\n\
             grid = {{ plugin = \"faulty-plugins#sound-brick\", level = 2, region = \"whole\" }}\n\
             [[device]]\nname = \"other\"\nplugin = \"faulty-plugins#{device}\"\nframe = {{ origin = [0, 0, 0.3] }}\n\
             [[tool]]\nname = \"thumb\"\ndevice = \"other\"\nradius = \"4 mm\"\n\
             [[edit]]\nkind = \"touch\"\ntool = \"thumb\""
        );
        let text = box_scene("integrator = \"symplectic-euler\"\nsubsteps = 8", "", &body);
        text.replace("[time]", "gravity = [0, 0, -9.81]\n[time]")
    };
    let rows = |bench: &Bench| {
        let columns = |row: &str| row.split(',').take(15).map(str::to_owned).collect::<Vec<_>>();
        let trace = String::from_utf8(bench.read("out/trace.csv")).expect("UTF-8");
        trace.lines().map(columns).collect::<Vec<_>>()
    };
    let bench = Bench::new();
    let args = ["run", "scene.toml", "-q", "--out", "out"];
    bench.write("scene.toml", beside("sound-springs", "sound-finger"));
    bench.pliant(&args).expect(0);
    let (sound, model) = (rows(&bench), bench.read("out/final-block.obj"));
    assert!(bench.summary("out")["contact_steps"].as_u64() > Some(10));
    for (material, device) in [
        ("panics-in-forces", "sound-finger"),
        ("forces-not-a-number", "sound-finger"),
        ("sound-springs", "panics-in-read"),
        ("sound-springs", "positions-not-a-number"),
        ("panics-in-forces", "lost-in-read"),
    ] {
        bench.write("scene.toml", beside(material, device));
        bench.pliant(&args).expect(if device == "positions-not-a-number" { 0 } else { 3 });
        let summary = bench.summary("out");
        assert!(summary["bodies"][0].get("frozen").is_none(), "{summary}");
        assert_eq!(summary["bodies"][1].get("frozen").is_some(), material != "sound-springs", "{summary}");
        assert_eq!(rows(&bench), sound, "{material}, {device}: the finger felt the same");
        assert!(bench.read("out/final-block.obj") == model, "{material}, {device}: and has the same shape");
    }
}

#[test]
fn a_plugin_that_is_missing_is_told_with_every_place_that_was_looked_in() {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("given")).expect("a folder");
    bench.write("scene.toml", box_scene("", "", ""));
    let args = ["run", "scene.toml", "--out", "out", "--plugin-path", "given", "--plugin-path", "absent"];
    let listed = bench.path("listed");
    let environment = [("PLIANT_PLUGIN_PATH", listed.to_str().expect("UTF-8"))];
    for key in ["body.0.material.plugin", "body.0.grid.plugin", "device.0.plugin"] {
        let set = format!("{key}=not-there");
        let ran = bench.pliant_with(&[&args[..], &["--set", &set]].concat(), &environment).expect(3);
        let ran = ran.says(&["error: no plugin `not-there`", &file_name("pliant_not_there"), &file_name("not_there")]);
        let places =
            ["given (--plugin-path)", "absent (--plugin-path): no such folder", "($PLIANT_PLUGIN_PATH): no such"];
        ran.says(&places).says(&[environment[0].1, "(beside the program)", "(the user's data folder)"]);
    }
    let at = bench.pliant(&[&args[..], &["--set", "device.0.plugin=./given/none.so"]].concat()).expect(3);
    at.says(&["no plugin `./given/none.so`", "looked for", "given/none.so"]);
    assert_eq!(bench.names("."), ["given", "scene.toml"]);
    bench.pliant(&["plugin", "info", "not-there"]).expect(3).says(&["no plugin `not-there`", "(beside the program)"]);
}

/// Runs the small scene with another device library in the folder `plugins`.
fn with_device(bench: &Bench, stem: &str, more: &[&str]) -> Ran {
    bench.write("scene.toml", box_scene("", "", ""));
    let set = format!("device.0.plugin={stem}");
    let args = ["run", "scene.toml", "-q", "--out", "out", "--plugin-path", "plugins", "--set", &set];
    bench.pliant(&[&args[..], more].concat())
}

#[test]
fn a_file_that_is_no_library_is_told_and_the_others_are_listed_all_the_same() {
    let bench = Bench::new();
    let real = std::fs::read(library("scripted").path()).expect("read");
    for (stem, bytes) in [
        ("empty", &b""[..]),
        ("words", b"this is not a library\n"),
        ("zeros", &[0; 8192]),
        ("head", &real[..64]),
        ("short", &real[..real.len().min(100_000)]),
    ] {
        let name = file_name(stem);
        bench.write(&format!("plugins/{name}"), bytes);
        let ran = with_device(&bench, stem, &[]).expect(3);
        ran.says(&["error: ", &name, "cannot be opened as a shared library: "]);
        assert!(!bench.path("out").exists(), "{stem}");
        let listed = bench.pliant(&["plugin", "list", "--plugin-path", "plugins", "--json"]).expect(3).json();
        let rows = listed["plugins"].as_array().expect("a list");
        let unusable =
            |row: &Value| row["error"].is_string() && row["path"].as_str().is_some_and(|p| p.ends_with(&name));
        assert!(rows.iter().any(unusable), "{listed}");
        assert!(rows.iter().any(|row| row["id"] == "mass-spring"), "{listed}");
        // It could be the device that somebody misses.
        let devices = ["--plugin-path", "plugins", "--json"];
        let probed = bench.pliant(&[&["device", "doctor"][..], &devices].concat()).expect(1).json();
        let told = |finding: &Value| {
            finding["what"] == format!("plugin `{stem}`")
                && finding["state"] == "missing"
                && finding["found"].is_string()
        };
        assert!(probed["host"].as_array().is_some_and(|host| host.iter().any(told)), "{probed}");
        let listed = bench.pliant(&[&["device", "list"][..], &devices].concat()).expect(3).json();
        assert!(listed["unusable"].as_array().is_some_and(|findings| findings.iter().any(told)), "{listed}");
    }
    let whole = file_name("whole");
    bench.write(&format!("plugins/{whole}"), real);
    with_device(&bench, "whole", &[]).expect(0);
}

/// A library whose entry is as given.
fn entry(fields: &str, rest: &str) -> String {
    format!(
        "#include \"pliant.h\"\n{rest}\n\
         static const pliant_descriptor *none(uint32_t i) {{ (void)i; return 0; }}\n\
         static const pliant_plugin *refuse(const pliant_host *h, const char *id) {{ (void)h; (void)id; return 0; }}\n\
         PLIANT_EXPORT const pliant_library pliant_entry = {{ {fields} }};\n\
         const void *const used[] = {{ (const void *)&none, (const void *)&refuse }};\n"
    )
}

#[test]
#[cfg_attr(not(unix), ignore = "needs a C compiler with the options of GNU and Clang")]
fn a_library_that_is_no_plugin_of_ours_is_told_and_the_others_are_listed_all_the_same() {
    let init = "static pliant_status init(const pliant_host *h, const char *f) { (void)h; (void)f; return PLIANT_IO; }";
    let named = |kind: &str, id: &str| {
        format!(
            "static const pliant_descriptor d = {{ sizeof d, {kind}, 0, {id}, \"n\", \"1\", \"s\", 0, 0, 0 }};\n\
             static const pliant_descriptor *one(uint32_t i) {{ return i == 0 ? &d : 0; }}"
        )
    };
    let endless = named("PLIANT_KIND_DEVICE", "\"d\"").replace("i == 0 ? &d : 0", "(void)i, &d");
    let size = "sizeof(pliant_library)";
    for (stem, text, said) in [
        ("nothing", "int something = 1;\n".to_owned(), &["no symbol `pliant_entry`", "not a pliant plugin"][..]),
        (
            "newer",
            entry(&format!("{size}, 2, 7, 0, none, refuse"), ""),
            &["made for plugin interface 2.7", "this host has 1.", "rebuild the plugin"],
        ),
        (
            "older",
            entry(&format!("{size}, 0, 3, 0, none, refuse"), ""),
            &["made for plugin interface 0.3", "this host has 1."],
        ),
        ("small", entry("8, 1, 0, 0, none, refuse", ""), &["entry of 8 bytes, at least"]),
        ("blank", entry(&format!("{size}, 1, 0, 0, 0, refuse"), ""), &["entry: `descriptor` is null"]),
        ("barren", entry(&format!("{size}, 1, 0, 0, none, 0"), ""), &["entry: `create` is null"]),
        (
            "hollow",
            entry(&format!("{size}, 1, 0, 0, none, refuse"), ""),
            &["no device `hollow` in this library; it has no plugins"],
        ),
        ("init", entry(&format!("{size}, 1, 0, init, none, refuse"), init), &["`init` failed: input or output failed"]),
        (
            "kind",
            entry(&format!("{size}, 1, 0, 0, one, refuse"), &named("77", "\"d\"")),
            &["plugin 0: unknown plugin kind 77"],
        ),
        (
            "unnamed",
            entry(&format!("{size}, 1, 0, 0, one, refuse"), &named("PLIANT_KIND_DEVICE", "0")),
            &["plugin 0: id is null"],
        ),
        ("twice", entry(&format!("{size}, 1, 0, 0, one, refuse"), &endless), &["plugin 1: `d` is declared twice"]),
        (
            "refuses",
            entry(&format!("{size}, 1, 0, 0, one, refuse"), &named("PLIANT_KIND_DEVICE", "\"d\"")),
            &["create: refused"],
        ),
    ] {
        let bench = Bench::new();
        bench.compile("plugins", stem, &text);
        let name = file_name(stem);
        with_device(&bench, stem, &["--set", "device.0.params={}"]).expect(3).says(&["error: ", &name]).says(said);
        assert!(!bench.path("out").exists(), "{stem}");
        if !["hollow", "refuses"].contains(&stem) {
            let listed = bench.pliant(&["plugin", "list", "--plugin-path", "plugins", "--json"]).expect(3).json();
            let rows = listed["plugins"].as_array().expect("a list");
            let error = |r: &&Value| r["error"].as_str().is_some_and(|e| said.iter().all(|part| e.contains(part)));
            assert_eq!(rows.iter().filter(error).count(), 1, "{stem}: {listed}");
            assert!(rows.iter().any(|r| r["id"] == "mass-spring"), "{stem}: the others are there");
        }
    }
}

#[test]
fn an_id_that_a_library_has_not_is_refused_and_a_library_s_only_plugin_needs_none() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    let run = |plugin: &str| {
        let set = format!("body.0.material.plugin={plugin}");
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--plugin-path", "plugins", "--set", &set])
    };
    run("mass-spring#nothing").expect(3).says(&["no material `nothing` in this library", "material `mass-spring`"]);
    run("mass-spring#").expect(3).says(&["no material `` in this library"]);
    run("octree-grid").expect(3).says(&["no material `octree-grid` in this library; it has grid `octree-grid`"]);
    assert_eq!(bench.names("."), ["scene.toml"]);
    run("mass-spring#mass-spring").expect(0);
    bench.write(
        &format!("plugins/{}", file_name("renamed")),
        std::fs::read(library("mass-spring").path()).expect("read"),
    );
    run("renamed").expect(0);
    run("renamed#mass-spring").expect(0);
}
