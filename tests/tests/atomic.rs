//! A run that fails or is stopped harms nothing that an earlier one left.

use pliant_tests::{Bench, box_scene};
use std::collections::BTreeMap;
use std::process::{Child, Command, Stdio};

/// Every file of a folder and of those in it, with its bytes.
fn files(bench: &Bench, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for name in bench.names(folder) {
        let path = format!("{folder}/{name}");
        if bench.path(&path).is_dir() {
            found.extend(files(bench, &path));
        } else {
            found.insert(path.clone(), bench.read(&path));
        }
    }
    found
}

/// A bench with the results of a run in `out`.
fn bench() -> (Bench, BTreeMap<String, Vec<u8>>) {
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
    assert!(aside.iter().all(|path| !path.contains(".partial")), "{aside:?}");
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
fn what_a_killed_run_leaves_is_removed_by_the_next() {
    let (bench, before) = bench();
    let long = ["run", "scene.toml", "--out", "out", "--set", "time.duration=1000"];
    let mut killed = Killed(bench.command(&long).stderr(Stdio::null()).spawn().expect("starts"));
    bench.wait_for_rows(&mut killed.0, &[]);
    let temporary = || bench.names("out").into_iter().filter(|name| name.ends_with(".partial")).collect::<Vec<_>>();
    let of_killed = temporary();
    // Another run into the same folder, which goes on: what it writes is not removed.
    let mut other = Killed(bench.command(&long).stderr(Stdio::null()).spawn().expect("starts"));
    drop(killed);
    bench.wait_for_rows(&mut other.0, &of_killed);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    let left = temporary();
    assert!(left.len() == 3 && left.iter().all(|name| !of_killed.contains(name)), "{left:?} after {of_killed:?}");
    drop(other);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    assert_eq!(temporary(), [""; 0]);
    assert_eq!(files(&bench, "out").keys().collect::<Vec<_>>(), before.keys().collect::<Vec<_>>());
}
