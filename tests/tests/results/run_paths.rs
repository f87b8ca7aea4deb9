//! The paths of a run are checked before its first step: no run is made whose results or recording could not be kept.

use pliant_tests::{Bench, box_scene};

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("scene.toml", box_scene("", "", ""));
    bench
}

#[test]
fn a_recording_in_the_place_of_a_result_is_refused_before_the_run() {
    let bench = bench();
    for name in [
        "final.obj",
        "final-other.obj",
        "summary.json",
        "frames",
        "frames/frame-00001.obj",
        "interrupted",
        "./trace.csv",
    ] {
        let path = format!("out/{name}");
        let run = ["run", "scene.toml", "-q", "--out", "out", "--record", &path];
        bench.pliant(&run).expect(2).says(&[&path, "a result of this run has this name", "allowed is another name"]);
    }
    for path in ["deep/out", "deep"] {
        let run = ["run", "scene.toml", "-q", "--out", "deep/out", "--record", path];
        bench.pliant(&run).expect(2).says(&[path, "the folder of the results or one above it"]);
    }
    assert_eq!(bench.names("."), ["scene.toml"], "nothing was written");
    for path in ["out/hand.rec", "out/frames/hand.rec", "out/deep/final.obj"] {
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--record", path]).expect(0);
        bench.pliant(&["replay", path, "-q", "--verify", "--out", "again"]).expect(0);
        assert!(bench.path("out/final.obj").is_file() && bench.path("out/summary.json").is_file(), "{path}");
    }
}

#[test]
#[cfg(unix)]
fn only_regular_files_are_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let bench = bench();
    bench.write("kept.rec", "mine");
    std::os::unix::fs::symlink("kept.rec", bench.path("link.rec")).expect("a link");
    std::fs::create_dir(bench.path("folder")).expect("a folder");
    let made = std::process::Command::new("mkfifo").arg(bench.path("pipe")).status().expect("mkfifo");
    assert!(made.success());
    // Devices are left to the test of the check itself: where this one fails, it would replace them.
    let cases = [("pipe", "a pipe"), ("link.rec", "a symbolic link"), ("folder", "a folder")];
    for (path, what) in cases {
        let said = [path, what, "allowed is a regular file or a new name"];
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--record", path]).expect(2).says(&said);
        assert!(!bench.path("out").exists(), "{path}: before the run");
        bench.pliant(&["sample", "elephant", "-o", path, "--force"]).expect(2).says(&said);
    }
    assert!(bench.path("pipe").metadata().expect("there").file_type().is_fifo());
    assert!(bench.path("link.rec").is_symlink() && bench.read("kept.rec") == b"mine");
    bench.pliant(&["run", "scene.toml", "-q", "--out", "pipe"]).expect(2).says(&["pipe"]);
    // A regular file is replaced.
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out", "--record", "kept.rec"]).expect(0);
    bench.pliant(&["replay", "kept.rec", "-q", "--out", "again"]).expect(0);
}

#[test]
#[cfg(unix)]
fn files_of_batches_and_reports_are_checked_before_the_work() {
    use pliant_tests::batch::{small_scene, small_sweep};
    let bench = Bench::new();
    bench.write("small.toml", small_scene());
    bench.write("sweep.toml", small_sweep(1, "").replace("scene.toml", "small.toml"));
    let link = |path: &str| {
        std::fs::create_dir_all(bench.path(path).parent().expect("a folder")).expect("made");
        std::os::unix::fs::symlink("nowhere", bench.path(path)).expect("a link");
    };
    link("table/results.csv");
    let said = ["results.csv", "a symbolic link"];
    bench.pliant(&["batch", "sweep.toml", "--out", "table", "-q"]).expect(2).says(&said);
    assert_eq!(bench.names("table"), ["results.csv"], "no edit was run");
    link("report/report.json");
    bench.pliant(&["report", "accuracy", "--out", "report", "-q"]).expect(2).says(&["report.json", "a symbolic link"]);
    assert_eq!(bench.names("report"), ["report.json"], "nothing was measured");
}

#[test]
#[cfg(target_os = "linux")]
fn a_recording_and_its_scene_may_have_paths_that_are_not_utf_8() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let bench = bench();
    let folder = bench.path(".").join(OsStr::from_bytes(b"caf\xe9"));
    std::fs::create_dir(&folder).expect("a folder");
    std::fs::write(folder.join("scene.toml"), box_scene("", "", "")).expect("written");
    let (scene, recording) = (folder.join("scene.toml"), folder.join(OsStr::from_bytes(b"\xff.rec")));
    let run = |args: &[&OsStr]| {
        let told = bench.command(&[]).args(args).output().expect("starts");
        assert_eq!(told.status.code(), Some(0), "{}", String::from_utf8_lossy(&told.stderr));
    };
    let [out, again] = ["out", "again"].map(|name| folder.join(name));
    let (scene, recording, out, again) = (scene.as_os_str(), recording.as_os_str(), out.as_os_str(), again.as_os_str());
    let [verb, quiet, to, record] = ["run", "-q", "--out", "--record"].map(OsStr::new);
    run(&[verb, scene, quiet, to, out, record, recording]);
    run(&["replay".as_ref(), recording, quiet, "--verify".as_ref(), to, again]);
    let read = |folder: &OsStr| std::fs::read(std::path::Path::new(folder).join("final.obj")).expect("there");
    assert!(read(out) == read(again));
}
