//! A device of a scene that takes its hands from a recording: the recorded scene gives the same bytes again, another scene gets the same strokes, and
//! what does not fit is refused with what is allowed.

use pliant_engine::edit::Falloff;
use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{Options, Session, SessionCommand};
use pliant_host::{POSE_VALID, Pose, SearchPath};
use pliant_mesh::testing::Random;
use pliant_record::{RecordingInputs, RecordingWriter, state_digest, write_model};
use pliant_tests::{Bench, box_scene, deps, loaded_kinds, open_file};

/// A scene with the hand of `hand.rec` in the place of its own.
fn with_recording(scene: &str) -> String {
    let lines =
        scene.lines().map(|line| if line.starts_with("params = { path") { "recording = \"hand.rec\"" } else { line });
    lines.map(|line| format!("{line}\n")).collect()
}

/// Models that the engine makes itself, each with the material that suits it, and a scene that presses or cuts them.
fn scenes(bench: &Bench) -> Vec<(&'static str, String)> {
    bench.pliant(&["sample", "elephant", "-o", "elephant.obj", "--detail", "1"]).expect(0);
    let shape = "shape = { kind = \"box\", cells = 12, size = [0.04, 0.04, 0.04] }";
    let elephant = box_scene("", "", "").replace(shape, "mesh = \"elephant.obj\"\nsize = 0.04");
    let knife = box_scene("", "", "")
        .replace("kind = \"touch\"", "kind = \"cut\"")
        .replace("radius = \"4 mm\"", "radius = \"4 mm\"\nblade = { length = 0.1 }")
        .replace(
            "[0.03, 0.0, 0.0, 0.001], [0.05, 0.002, 0.0, 0.001]",
            "[0.02, 0.0, 0.0, -0.03], [0.05, 0.03, 0.0, -0.03]",
        );
    let cloth = box_scene("integrator = \"backward-euler\"", "", "")
        .replace(shape, "shape = { kind = \"sheet\", cells = 12, rows = 12, size = [0.04, 0.04, 0] }")
        .replace("plugin = \"mass-spring\" }\ngrid = { level = 5 }", "plugin = \"cloth\" }\nsheet = {}")
        .replace(
            "frame = { body = \"block\", from = [0.45, 0.55, 2.0], toward = [0.45, 0.55, 0.5] }",
            "frame = { origin = [0.02, 0.02, 0] }",
        );
    vec![
        ("box", box_scene("", "", "")),
        ("implicit box", box_scene("integrator = \"backward-euler\"", "", "")),
        ("elephant", elephant),
        ("cut", knife),
        ("cloth", cloth),
    ]
}

#[test]
fn the_recorded_scene_gives_the_same_bytes_and_is_recorded_again() {
    let bench = Bench::new();
    for (name, scene) in scenes(&bench) {
        bench.write("first.toml", &scene);
        bench.pliant(&["run", "first.toml", "-q", "--out", "first", "--record", "hand.rec"]).expect(0);
        let summary = bench.summary("first");
        let is_cut = summary["cut"]["area"].as_f64().unwrap_or_default() > 0.0;
        assert!(is_cut || summary["largest_force"].as_f64().unwrap() > 0.0, "{name} is touched");
        assert_eq!(is_cut, name == "cut");
        bench.write("again.toml", with_recording(&scene));
        bench.pliant(&["run", "again.toml", "-q", "--out", "again", "--record", "again.rec"]).expect(0);
        for file in ["final.obj", "nodes.csv"] {
            assert_eq!(bench.read(&format!("first/{file}")), bench.read(&format!("again/{file}")), "{name}: {file}");
        }
        let kinds = loaded_kinds(&bench.summary("again"));
        assert!(kinds.iter().all(|kind| kind != "device"), "{name}: no device is opened: {kinds:?}");
        bench.pliant(&["replay", "again.rec", "--verify", "-q"]).expect(0);
    }
}

/// Hands that come and go, undo, redo and tools that change their size: steps and commands of the recording come in the scene as they came.
#[test]
fn commands_of_the_recording_come_with_its_hands() {
    let (mut random, bench) = (Random(12), Bench::new());
    let path = bench.write("scene.toml", box_scene("", "", "release = \"keep\""));
    let (scene, source) = scene::load(&path, &[]).unwrap();
    let plan = Plan::new(&scene, &source).unwrap();
    let options = Options::new(SearchPath::new(&[deps()]), 1);
    let mut session = Session::open(&scene, &source, plan, &options).unwrap();
    session.keep_history();
    let inputs =
        RecordingInputs { scene: &scene, source: &source, session: &session, mesh: None, live: false, history: true };
    let mut writer = RecordingWriter::create(&bench.path("hand.rec"), &inputs).unwrap();
    let mut digests = Vec::new();
    let commands = [
        SessionCommand::Undo,
        SessionCommand::Redo,
        SessionCommand::ResizeTools { radius: 6e-3, coupling: 150.0 },
        SessionCommand::SetBrush { strength: 2.5, falloff: Falloff::Sharp },
        SessionCommand::Undo,
    ];
    for command in commands {
        for at in 0..60 {
            let pose = Pose {
                flags: POSE_VALID,
                position: [1e-3 * random.unit(), 0.0, 0.006 - 2e-4 * f64::from(at.min(30))],
                orientation: [0.0, 0.0, 0.0, 1.0],
                ..Pose::default()
            };
            session.step_with(&[[if at < 35 { pose } else { Pose::default() }]]);
            writer.step(&session, session.frame().tools.iter().map(|tool| tool.device_force)).unwrap();
            digests.push(state_digest(&session));
        }
        writer.command(&command).unwrap();
        session.apply(command);
    }
    session.step_with(&[[Pose::default()]]);
    writer.step(&session, session.frame().tools.iter().map(|tool| tool.device_force)).unwrap();
    digests.push(state_digest(&session));
    writer.finish().unwrap();
    session.update_surface();
    let saved = bench.path("saved.obj");
    write_model(&session.bodies[0], &session.plan().cap_material, &saved).unwrap();

    let duration = digests.len() as f64 * session.dt();
    let text = with_recording(&box_scene("", "", "release = \"keep\""))
        .replace("duration = 0.05", &format!("duration = {duration}"));
    let mut again = open_file(&bench.write("again.toml", &text), 2, None);
    for (step, digest) in digests.iter().enumerate() {
        again.step();
        assert_eq!(state_digest(&again), *digest, "step {step}");
    }
    // A hand without samples is let go after 50 ms.
    (0..60).for_each(|_| again.step());
    assert!(!again.tools[0].hand.present, "after the end of the recording the hand is absent");
    bench.pliant(&["run", "again.toml", "-q", "--out", "out", "--record", "again.rec"]).expect(0);
    assert_eq!(bench.read("saved.obj"), bench.read("out/final.obj"));
    bench.pliant(&["replay", "again.rec", "--verify", "-q"]).expect(0);
}

#[test]
fn another_scene_gets_the_same_hand() {
    let bench = Bench::new();
    let scene = box_scene("", "", "");
    bench.write("first.toml", &scene);
    bench.pliant(&["run", "first.toml", "-q", "--out", "first", "--record", "hand.rec"]).expect(0);
    let stiff = with_recording(&scene)
        .replace("plugin = \"mass-spring\"", "plugin = \"mass-spring\", params = { young = \"80 kPa\" }")
        .replace("name = \"hand\"", "name = \"arm\"\nrecorded = \"hand\"")
        .replace("device = \"hand\"", "device = \"arm\"");
    bench.write("stiff.toml", stiff);
    bench.pliant(&["run", "stiff.toml", "-q", "--out", "stiff"]).expect(0);
    let [soft, stiff] = ["first", "stiff"].map(|out| bench.summary(out)["largest_force"].as_f64().unwrap());
    assert!(stiff > 1.2 * soft, "{soft} N, {stiff} N");
}

#[test]
fn what_does_not_fit_is_refused_with_what_is_allowed() {
    let bench = Bench::new();
    let scene = box_scene("", "", "");
    bench.write("first.toml", &scene);
    bench.pliant(&["run", "first.toml", "-q", "--out", "first", "--record", "hand.rec"]).expect(0);
    bench.write("not.rec", "no recording");
    let recording = "recording = \"hand.rec\"";
    let scene = with_recording(&scene);
    for (from, to, says) in [
        ("[time]", "[time]\ndt = \"2 ms\"", &["steps of 0.001 s", "`[time] dt` is 0.002 s"][..]),
        (recording, "recording = \"nowhere.rec\"", &["nowhere.rec", "cannot be read"]),
        (recording, "recording = \"not.rec\"", &["not.rec", "does not begin with PLIANTRC"]),
        (recording, "recording = \"hand.rec\"\nrecorded = \"foot\"", &["`foot`", "allowed for `recorded` is `hand`"]),
        (recording, "recording = \"hand.rec\"\nplugin = \"scripted\"", &["allowed is one of them"]),
        (recording, "recorded = \"hand\"", &["`recorded` names a device of a `recording`"]),
    ] {
        bench.write("bad.toml", scene.replacen(from, to, 1));
        bench.pliant(&["run", "bad.toml"]).expect(2).says(says).says(&["bad.toml:"]);
    }
    bench.write("good.toml", &scene);
    bench.pliant(&["run", "good.toml", "--live"]).expect(2).says(&["allowed is a run without `--live`"]);
    let over = bench.pliant(&["run", "good.toml", "--record", "hand.rec"]).expect(2);
    over.says(&["a recording of this run"]);
}
