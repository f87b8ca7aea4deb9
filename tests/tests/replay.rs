//! A recorded session comes back to the bit, and a file that is not whole is refused with what is wrong.

use pliant_record::{Digest, Recording};
use pliant_tests::{Bench, box_scene};

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
        let loaded = bench.summary("again")["loaded"].to_string();
        assert!(!loaded.contains("scripted"), "no device is opened: {loaded}");
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
    newer[8] = 2;
    for (bytes, says) in [
        (b"solid cube".to_vec(), "does not begin with PLIANTRC"),
        (newer, "version 2; allowed is 1"),
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
