//! A recorded session comes back to the bit, and a file that is not whole is refused with what is wrong.

use pliant_engine::edit::Falloff;
use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{Options, Session, SessionCommand};
use pliant_host::{POSE_VALID, Pose, SearchPath};
use pliant_mesh::testing::Random;
use pliant_record::{Digest, Recording, RecordingInputs, RecordingWriter, state_digest};
use pliant_tests::{Bench, box_scene, deps, loaded_kinds};
use std::fs::File;
use std::io::BufWriter;

/// A folder with a scene, run and recorded.
fn recorded(time: &str, rest: &str) -> Bench {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene(time, "", rest));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "first", "--record", "hand.rec"]).expect(0);
    bench
}

/// The trace without the seconds a step took.
fn untimed(bench: &Bench, name: &str) -> Vec<String> {
    let text = String::from_utf8(bench.read(name)).unwrap();
    text.lines().map(|row| row.rsplit_once(',').unwrap().0.to_owned()).collect()
}

#[test]
fn a_replay_without_the_device_leaves_the_same_bytes() {
    for time in ["integrator = \"symplectic-euler\"", "integrator = \"backward-euler\""] {
        let bench = recorded(time, "");
        let ran = bench.pliant(&["replay", "hand.rec", "--verify", "--out", "again", "--threads", "1"]).expect(0);
        ran.says(&["the same state, to the bit, after each of 50 steps"]);
        for name in ["final.obj", "nodes.csv"] {
            assert_eq!(bench.read(&format!("first/{name}")), bench.read(&format!("again/{name}")), "{name}");
        }
        assert_eq!(untimed(&bench, "first/trace.csv"), untimed(&bench, "again/trace.csv"));
        let kinds = loaded_kinds(&bench.summary("again"));
        assert!(kinds.iter().all(|kind| kind != "device"), "no device is opened: {kinds:?}");
    }
}

#[test]
fn another_material_under_the_same_hand_gives_another_force() {
    let bench = recorded("", "");
    let set = "body.0.material.params.young=80 kPa";
    bench.pliant(&["replay", "hand.rec", "-q", "--set", set, "--out", "stiff"]).expect(0);
    let [soft, stiff] = ["first", "stiff"].map(|out| bench.summary(out)["largest_force"].as_f64().unwrap());
    assert!(stiff > 1.2 * soft, "{soft} N, {stiff} N");
    let hands = |out: &str| -> Vec<String> {
        let trace = untimed(&bench, &format!("{out}/trace.csv"));
        trace.iter().map(|row| row.split(',').take(4).collect::<Vec<_>>().join(",")).collect()
    };
    assert_eq!(hands("first"), hands("stiff"));
    let refused = bench.pliant(&["replay", "hand.rec", "--set", "time.dt=2ms"]).expect(2);
    refused.says(&["dt 0.002 s", "allowed is 0.001 s"]);
    bench.pliant(&["replay", "hand.rec", "--verify", "--set", set]).expect(2);
}

#[test]
fn a_state_that_differs_is_told_with_its_time() {
    let bench = recorded("", "");
    let mut bytes = bench.read("hand.rec");
    // The digest of the state ends each step; all steps are of one length, and 13 + 8 bytes come after the last.
    let step = 5 + 96 + 24 + 8;
    let at = bytes.len() - 21 - 30 * step - 1;
    bytes[at] ^= 1;
    let end = bytes.len() - 8;
    let sum = checksum(&bytes[..end]).to_le_bytes();
    bytes[end..].copy_from_slice(&sum);
    bench.write("forged.rec", bytes);
    bench.pliant(&["replay", "forged.rec", "--verify"]).expect(1).says(&["differs from the recorded one at 0.0200 s"]);
    bench.pliant(&["replay", "forged.rec"]).expect(0);
}

/// As the format has it: the start, then head and content of each block.
fn checksum(bytes: &[u8]) -> u64 {
    let mut digest = Digest::default();
    digest.bytes(&bytes[..12]);
    let mut at = 12;
    while at < bytes.len() {
        let length = u32::from_le_bytes(bytes[at + 1..at + 5].try_into().unwrap()) as usize;
        digest.bytes(&bytes[at..at + 5]);
        digest.bytes(&bytes[at + 5..at + 5 + length]);
        at += 5 + length;
    }
    digest.value()
}

#[test]
fn files_that_are_cut_off_or_changed_are_refused_with_what_is_wrong() {
    let bench = recorded("", "");
    let whole = bench.read("hand.rec");
    let refused = |bytes: &[u8]| Recording::read(&bench.write("bad.rec", bytes)).err().map(|e| e.to_string());
    assert_eq!(refused(&whole), None);
    for length in (0..whole.len()).step_by(211).chain([whole.len() - 1]) {
        let text = refused(&whole[..length]).unwrap_or_else(|| panic!("{length} bytes"));
        assert!(text.contains("cut off") || length < 8, "{length}: {text}");
    }
    for at in (0..whole.len()).step_by(97) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        assert!(refused(&bytes).is_some(), "byte {at} of {}", whole.len());
    }
    let mut newer = whole.clone();
    newer[8] = 5;
    for (bytes, says) in [
        (b"solid cube".to_vec(), "does not begin with PLIANTRC"),
        (newer, "version 5; allowed are 1 to 4"),
        ([&whole[..], b"more"].concat(), "4 bytes too many"),
    ] {
        let path = bench.write("bad.rec", bytes);
        bench.pliant(&["replay", path.to_str().unwrap()]).expect(2).says(&[says, "bad.rec"]);
    }
    bench.pliant(&["replay", "nowhere.rec"]).expect(2).says(&["nowhere.rec", "cannot be read"]);
}

#[test]
fn a_model_that_has_changed_is_named() {
    let bench = Bench::new();
    let scene = box_scene("", "", "").replace(
        r#"shape = { kind = "box", cells = 12, size = [0.04, 0.04, 0.04] }"#,
        "mesh = \"cube.obj\"\nsize = 0.04",
    );
    bench.write("scene.toml", scene);
    bench.pliant(&["sample", "elephant", "-o", "cube.obj", "--detail", "1"]).expect(0);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "first", "--record", "hand.rec"]).expect(0);
    bench.pliant(&["replay", "hand.rec", "--verify", "-q"]).expect(0);
    let mut model = bench.read("cube.obj");
    model.extend_from_slice(b"# touched\n");
    bench.write("cube.obj", model);
    bench.pliant(&["replay", "hand.rec"]).expect(2).says(&["cube.obj has changed since it was recorded"]);
}

/// A session with commands between its steps and hands that come and go, as a window records it: every state comes back, and steps
/// in which no hand is there and nothing changes take no room.
#[test]
fn commands_and_idle_steps_come_back() {
    let (mut random, bench) = (Random(9), Bench::new());
    let path = bench.write("scene.toml", box_scene("", "", "release = \"keep\"\nbutton = 0\nsymmetry = \"xz\""));
    for round in 0..3 {
        let (scene, source) = scene::load(&path, &[]).unwrap();
        let plan = Plan::new(&scene, &source).unwrap();
        let options = Options::new(SearchPath::new(&[deps()]), 1);
        let mut session = Session::open(&scene, &source, plan, &options).unwrap();
        session.keep_history();
        let inputs = RecordingInputs {
            scene: &scene,
            source: &source,
            session: &session,
            mesh: None,
            live: false,
            history: true,
        };
        let mut writer = RecordingWriter::unnamed(&inputs).unwrap();
        let (mut digests, mut given) = (Vec::new(), Vec::new());
        let mut steps =
            |session: &mut Session, writer: &mut RecordingWriter<BufWriter<File>>, count: usize, pose: Pose| {
                for _ in 0..count {
                    session.step_with(&[[pose]]);
                    writer.step(session, session.frame().tools.iter().map(|tool| tool.device_force)).unwrap();
                    digests.push(state_digest(session));
                }
            };
        let present = |height: f64, buttons: u32| Pose {
            flags: POSE_VALID,
            buttons,
            position: [0.0, height, 0.0],
            orientation: [0.0, 0.0, 0.0, 1.0],
            ..Pose::default()
        };
        for _ in 0..4 {
            for at in 0..20 {
                steps(&mut session, &mut writer, 1, present(0.03 - 2e-4 * f64::from(at), 1));
            }
            steps(&mut session, &mut writer, 30 + 40 * round, Pose::default());
            let command = match random.below(11) {
                0 | 1 => SessionCommand::Undo,
                2 => SessionCommand::Redo,
                3 => SessionCommand::AddLayer { name: format!("layer \u{3b2} {round}") },
                4 => SessionCommand::SetLayerStrength { layer: 0, strength: random.unit().abs() },
                5 => SessionCommand::RecordLayer { layer: Some(0).filter(|_| random.below(2) == 0) },
                6 => SessionCommand::DeleteLayer { layer: 0 },
                7 => SessionCommand::RenameLayer { layer: 0, name: String::new() },
                8 => SessionCommand::SetBrush {
                    strength: 0.1 + random.unit().abs(),
                    falloff: Falloff::ALL[random.below(6) as usize],
                },
                9 => SessionCommand::SetSymmetry {
                    axes: std::array::from_fn(|_| random.below(2) == 0),
                    centre: 1e-3 * random.vector(),
                },
                _ => SessionCommand::ResizeTools {
                    radius: 3e-3 + 6e-3 * random.unit(),
                    coupling: 50.0 + 250.0 * random.unit(),
                },
            };
            writer.command(&command).unwrap();
            session.apply(command.clone());
            given.push(command);
        }
        steps(&mut session, &mut writer, 5, Pose::default());
        let file = bench.path("window.rec");
        let own = writer.save_as(&path, &source, &session, false).expect_err("it is the scene").to_string();
        assert!(own.contains("the scene of this run"), "{own}");
        writer.save_as(&file, &source, &session, false).unwrap();
        let bytes = bench.read("window.rec");
        steps(&mut session, &mut writer, 1000, Pose::default());
        writer.save_as(&file, &source, &session, false).unwrap();
        let more = bench.read("window.rec").len() - bytes.len();
        assert!(more < 200 * 133, "1000 idle steps take {more} bytes");
        let recording = Recording::read(&file).unwrap();
        assert_eq!(recording.step_count(), digests.len() as u64);
        let commands = recording.steps.iter().flat_map(|step| &step.commands);
        assert_eq!(commands.cloned().collect::<Vec<_>>(), given);
        let recorded = recording.steps.iter().flat_map(|step| (0..step.count).map(|_| step.digest));
        assert!(recorded.eq(digests));
        bench.pliant(&["replay", "window.rec", "--verify", "-q"]).expect(0);
    }
}
