//! A run that fails or is stopped harms nothing that an earlier one left.

use pliant_tests::result_sets::{FileSet, files, set_of};
use pliant_tests::{Bench, box_scene};
use std::process::{Child, Command, Stdio};

/// A bench with the results of a run in `out`.
fn bench() -> (Bench, FileSet) {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", "[output]\nframes = 100"));
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    let before = files(&bench, "out");
    assert_eq!(before.len(), 4 + 6, "{:?}", before.keys());
    (bench, before)
}

#[test]
fn a_run_that_cannot_begin_leaves_the_results_of_the_one_before() {
    let (bench, before) = bench();
    bench.write("bad.obj", "v 0 0 nan\n");
    for (args, code) in [
        (&["--set", "body.0.material.plugin=nobody"][..], 3),
        (&["--set", "tool.0.radius=-1"], 2),
        (&["--set", "time.dt=0.01", "--set", "time.integrator=explicit-euler"], 2),
        (&["--mesh", "bad.obj"], 2),
    ] {
        bench.pliant(&[&["run", "scene.toml", "--out", "out"], args].concat()).expect(code);
        assert!(files(&bench, "out") == before, "{args:?}");
        bench.pliant(&[&["run", "scene.toml", "--out", "new"], args].concat()).expect(code);
        assert!(!bench.path("new").exists(), "{args:?}: not even a folder");
    }
}

#[test]
fn a_folder_that_cannot_be_written_to_is_found_before_the_run() {
    let (bench, before) = bench();
    bench.write("file", "not a folder");
    for out in ["file", "file/below"] {
        for output in ["output.trace=true", "output.trace=false"] {
            // A million steps: what is found only at the end is never found here.
            let long = ["run", "scene.toml", "--out", out, "--set", output, "--set", "time.duration=1000"];
            bench.pliant(&long).expect(2).says(&["error: file"]);
        }
    }
    assert_eq!(bench.read("file"), b"not a folder");
    assert!(files(&bench, "out") == before);
}

#[test]
#[cfg(unix)]
fn a_run_that_is_stopped_puts_what_it_has_aside() {
    use std::os::unix::process::ExitStatusExt;

    let (bench, before) = bench();
    let args = ["run", "scene.toml", "--out", "out", "--set", "time.duration=1000"];
    let mut child = bench.command(&args).stderr(Stdio::piped()).spawn().expect("starts");
    bench.wait_for_rows(&mut child, &[]);
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill").success());
    let told = child.wait_with_output().expect("ends");
    assert_eq!((told.status.code(), told.status.signal()), (Some(130), None));
    assert!(String::from_utf8_lossy(&told.stderr).contains("stopped; results so far are in out/interrupted"));

    let mut after = files(&bench, "out");
    let aside: Vec<String> = after.keys().filter(|path| path.starts_with("out/interrupted/")).cloned().collect();
    for name in ["final.obj", "frames/frame-00000.obj", "nodes.csv", "summary.json", "trace.csv"] {
        assert!(aside.contains(&format!("out/interrupted/{name}")), "{name} of {aside:?}");
    }
    assert!(aside.iter().all(|path| !path.contains(".partial")) && bench.stages().is_empty(), "{aside:?}");
    let summary = bench.summary("out/interrupted");
    let steps = summary["steps"].as_u64().expect("steps");
    assert!(summary["interrupted"] == true && (100..1_000_000).contains(&steps), "{steps}");
    let trace = String::from_utf8(bench.read("out/interrupted/trace.csv")).expect("UTF-8");
    assert_eq!(trace.lines().count() as u64, steps + 1);
    after.retain(|path, _| !aside.contains(path));
    assert!(after == before, "{:?}", after.keys());
}

/// A child that is killed when it is dropped, also if the test fails.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn what_a_killed_run_leaves_is_removed_by_the_next_and_two_writers_are_refused() {
    let (bench, before) = bench();
    let long = ["run", "scene.toml", "--out", "out", "--set", "time.duration=1000"];
    let mut killed = Killed(bench.command(&long).stderr(Stdio::null()).spawn().expect("starts"));
    bench.wait_for_rows(&mut killed.0, &[]);
    let of_killed = bench.stages();
    let refused = bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(2);
    refused.says(&["out", "another run", "--out"]);
    assert!(bench.stages() == of_killed && files(&bench, "out") == before);
    drop(killed);
    assert_eq!(bench.stages(), of_killed);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    assert_eq!(bench.stages(), [""; 0]);
    assert_eq!(files(&bench, "out").keys().collect::<Vec<_>>(), before.keys().collect::<Vec<_>>());
}

/// Two scenes with other files: one with frames and nodes, one with a picture of forces.
const SCENES: [&[&str]; 2] = [
    &["run", "scene.toml", "-q", "--set", "output.frames=100"],
    &[
        "run",
        "scene.toml",
        "-q",
        "--set",
        "output.forces=true",
        "--set",
        "output.nodes=false",
        "--set",
        "time.duration=0.03",
    ],
];

/// Both sets, each from a run of its own, and a bench with the first one in `out`.
fn two_sets() -> (Bench, [FileSet; 2]) {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    let sets = [0, 1].map(|i| {
        let folder = format!("whole-{i}");
        bench.pliant(&[SCENES[i], &["--out", &folder]].concat()).expect(0);
        set_of(&bench, &folder)
    });
    assert!(sets[0].keys().ne(sets[1].keys()));
    bench.pliant(&[SCENES[0], &["--out", "out"]].concat()).expect(0);
    assert!(set_of(&bench, "out") == sets[0]);
    (bench, sets)
}

#[test]
#[cfg(unix)]
fn a_run_killed_at_any_moment_leaves_the_old_set_or_the_new_one() {
    use pliant_mesh::testing::Random;
    let (bench, sets) = two_sets();
    let lengths = [1, 0].map(|scene| {
        let began = std::time::Instant::now();
        bench.pliant(&[SCENES[scene], &["--out", "out"]].concat()).expect(0);
        began.elapsed().as_secs_f64()
    });
    let (mut random, mut seen) = (Random(38), [0, 0]);
    // Runs take longer or shorter than the first ones did: what came before the end or after it tells, whatever else the machine does.
    let (mut stretch, mut before) = (1.0, 0);
    for trial in 0..40 {
        let mut child = bench.command(&[SCENES[trial % 2], &["--out", "out"]].concat()).spawn().expect("starts");
        // Half of them about the end, where files get their names.
        let share = if trial % 4 < 2 { random.unit() } else { 0.7 + 0.6 * random.unit() };
        std::thread::sleep(std::time::Duration::from_secs_f64(stretch * share * lengths[1 - trial % 2]));
        child.kill().and_then(|()| child.wait()).expect("killed");
        let found = set_of(&bench, "out");
        let which = sets.iter().position(|set| *set == found);
        let which = which.unwrap_or_else(|| panic!("trial {trial}: a mix: {:?}", found.keys()));
        seen[which] += 1;
        // Only where the old set is that of the other scene can it be told whether the run has ended.
        if before != trial % 2 {
            stretch *= if which == trial % 2 { 0.85 } else { 1.25 };
        }
        before = which;
    }
    assert!(seen.iter().all(|n| *n > 0), "{seen:?}");
    bench.pliant(&[SCENES[0], &["--out", "out"]].concat()).expect(0);
    assert_eq!(bench.names("."), ["out", "scene.toml", "whole-0", "whole-1"], "nothing has piled up");
}

#[test]
#[cfg(target_os = "linux")]
fn a_write_that_fails_leaves_the_old_set_and_names_the_file() {
    let (bench, sets) = two_sets();
    let mut failures = 0;
    // The limit of a file's size (blocks of 512 bytes) stands for a disk that is full.
    for blocks in [0, 1, 2, 8, 16, 32, 64, 128, 256, 512] {
        let mut shell = Command::new("sh");
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
        let own = bench.command(&[SCENES[1], &["--out", "out"]].concat());
        shell.args(["-c", &script, "sh"]).arg(own.get_program()).args(own.get_args()).current_dir(bench.path("."));
        let told = shell.env_remove("PLIANT_PLUGIN_PATH").output().expect("starts");
        let text = String::from_utf8_lossy(&told.stderr).into_owned();
        if told.status.code() == Some(0) {
            break;
        }
        failures += 1;
        assert_eq!(told.status.code(), Some(2), "{blocks}: {text}");
        let named =
            ["final.obj", "trace.csv", "summary.json", "forces.svg", "out"].iter().any(|name| text.contains(name));
        assert!(named, "{blocks}: {text}");
        assert!(set_of(&bench, "out") == sets[0], "{blocks}");
        assert_eq!(bench.stages(), [""; 0], "{blocks}");
    }
    assert!(failures >= 3, "{failures}");
}

#[test]
fn what_the_program_did_not_write_stays() {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    bench.write("out/frames/picture.png", "mine");
    bench.write("out/notes/final.obj", "mine");
    for set in SCENES {
        bench.pliant(&[set, &["--out", "out"]].concat()).expect(0);
        assert_eq!(
            (bench.read("out/frames/picture.png"), bench.read("out/notes/final.obj")),
            (b"mine".into(), b"mine".into())
        );
    }
    // Frames of the scene before are gone with it.
    assert_eq!(bench.names("out/frames"), ["picture.png"]);
    bench.write("other/final.obj", "mine");
    bench.pliant(&[SCENES[0], &["--out", "other"]].concat()).expect(2).says(&["other/final.obj", "--out"]);
    assert!(bench.read("other/final.obj") == b"mine" && bench.names("other") == ["final.obj"]);
}

#[test]
fn an_input_is_not_written_over() {
    let bench = Bench::new();
    bench.pliant(&["sample", "elephant", "-o", "final.obj"]).expect(0);
    bench.write("scene.toml", box_scene("", "", ""));
    let model = bench.read("final.obj");
    let run = ["run", "scene.toml", "-q", "--mesh", "final.obj"];
    let is_kept = || assert!(bench.read("final.obj") == model && bench.read("scene.toml").starts_with(b"format"));
    bench.pliant(&[&run[..], &["--out", "."]].concat()).expect(2).says(&["final.obj"]);
    is_kept();
    for file in ["final.obj", "./final.obj", "scene.toml"] {
        let record = [&run[..], &["--out", "out", "--record", file]].concat();
        bench.pliant(&record).expect(2).says(&[file, "of this run"]);
        is_kept();
    }
    // The same by another name.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("final.obj", bench.path("link.obj")).expect("a link");
        bench.pliant(&[&run[..], &["--out", "out", "--record", "link.obj"]].concat()).expect(2);
        is_kept();
    }
    assert!(!bench.path("out").exists());
}

#[test]
#[cfg(target_os = "linux")]
fn a_path_that_is_not_utf_8_keeps_the_results() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let bench = Bench::new();
    let folder = OsStr::from_bytes(b"caf\xe9");
    let at = bench.path(".").join(folder);
    std::fs::create_dir(&at).expect("a folder");
    std::fs::write(at.join("scene.toml"), box_scene("", "", "")).expect("written");
    for (json, out) in [(false, "out"), (true, "out2")] {
        let mut command = bench.command(&["run", "-q", "--out"]);
        command.arg(at.join(out)).arg(at.join("scene.toml"));
        if json {
            command.arg("--json");
        }
        let told = command.output().expect("starts");
        assert_eq!(told.status.code(), Some(0), "{}", String::from_utf8_lossy(&told.stderr));
        let summary = std::fs::read(at.join(out).join("summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_slice(&summary).expect("whole");
        assert!(summary["scene"].as_str().is_some_and(|scene| scene.ends_with("scene.toml")), "{summary}");
    }
}
