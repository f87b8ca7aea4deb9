//! What goes wrong in a batch is a row or a sentence, and never takes the rest along.

use pliant_batch::{RunOptions, Sweep, run};
use pliant_host::SearchPath;
use pliant_tests::batch::{rows, run_batch, small_bench, small_scene, small_sweep};
use pliant_tests::{Bench, wait_until};
use serde_json::Value;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A sweep over materials, one of which has a fault.
fn faulty_bench(fault: &str, rest: &str) -> Bench {
    let bench = Bench::new();
    let scene = small_scene().replace("plugin = \"mass-spring\"", "plugin = \"faulty-plugins#sound-springs\"");
    bench.write("scene.toml", scene);
    let sweep = format!(
        "format = 1\nscene = \"scene.toml\"\n\
         [[axis]]\npath = \"body.0.material.plugin\"\nname = \"material\"\n\
         list = [\"faulty-plugins#sound-springs\", \"faulty-plugins#{fault}\"]\n\
         [[axis]]\npath = \"tool.0.radius\"\nlist = [\"3 mm\", \"5 mm\"]\n{rest}"
    );
    bench.write("sweep.toml", sweep);
    bench
}

/// Checks that the sound edits of such a sweep are done and the others failed with this class and message.
fn expect_failed(bench: &Bench, class: &str, said: &str) {
    let rows = rows(bench, "out");
    assert_eq!(rows.len(), 4);
    for row in &rows[..2] {
        assert_eq!((&row["status"], &row["class"]), (&Value::from("done"), &Value::Null), "{row}");
        assert!(row["steps"] == 12 && row["deepest"].as_f64() > Some(0.0), "{row}");
    }
    for row in &rows[2..] {
        assert_eq!((&row["status"], &row["class"]), (&Value::from("failed"), &Value::from(class)), "{row}");
        assert!(row["message"].as_str().is_some_and(|message| message.contains(said)), "{row}");
    }
}

#[test]
fn forces_that_are_no_numbers_and_panics_are_rows() {
    for (fault, class, said) in [
        ("forces-not-a-number", "quarantine", "forces-not-a-number"),
        ("panics-in-new", "plugin", "panicked on purpose, in new"),
        ("no-mass", "plugin", "allowed is a finite mass"),
    ] {
        let bench = faulty_bench(fault, "");
        run_batch(&bench, &["--out", "out"]).expect(1);
        expect_failed(&bench, class, said);
        let shards = bench.pliant(&["batch", "status", "out", "--json"]).expect(0).json();
        assert_eq!(shards[0]["failed"][class], 2, "{shards}");
    }
}

#[test]
fn failed_edits_are_kept_or_done_again() {
    let bench = faulty_bench("forces-not-a-number", "");
    run_batch(&bench, &["--out", "out"]).expect(1);
    let kept = run_batch(&bench, &["--out", "out", "--resume", "--json"]).expect(1).json();
    assert_eq!((&kept["new"], &kept["failed"]), (&Value::from(0), &Value::from(2)));
    let again = run_batch(&bench, &["--out", "out", "--resume", "--retry-failed", "--json"]).expect(1).json();
    assert_eq!((&again["new"], &again["failed"]), (&Value::from(2), &Value::from(2)));
    assert_eq!(rows(&bench, "out").len(), 4);
}

#[test]
fn a_plugin_that_never_returns_costs_its_own_edits_alone() {
    for isolate in [&[][..], &["--isolate"]] {
        let bench = faulty_bench("hangs", "[limits]\nseconds = 4\nretries = 1\n");
        let began = Instant::now();
        run_batch(&bench, &[&["--out", "out", "--jobs", "2"], isolate].concat()).expect(1);
        // Two edits at a time, two tries of four seconds and some patience; the rest is for a busy machine.
        assert!(began.elapsed() < Duration::from_secs(120), "{:?}", began.elapsed());
        expect_failed(&bench, "time-limit", "longer than the 4 s");
    }
}

#[test]
fn a_plugin_that_ends_its_process_ends_a_child_alone() {
    let bench = faulty_bench("aborts", "[limits]\nretries = 1\n");
    run_batch(&bench, &["--out", "out", "--isolate"]).expect(1);
    expect_failed(&bench, "crash", "signal 6 (abort)");
    let csv = ["batch", "collect", "out", "--timings", "--output", "timings.jsonl"];
    bench.pliant(&csv).expect(0);
    let text = String::from_utf8(bench.read("timings.jsonl")).unwrap();
    let attempts: Vec<Value> =
        text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap()["attempts"].clone()).collect();
    assert_eq!(attempts, [1, 1, 2, 2].map(Value::from));
}

/// A child that ends well without results has none; one whose plugin panics or is quarantined says so itself.
#[test]
fn what_happens_in_a_child_is_a_row_with_its_class() {
    for (fault, class, said) in [
        ("exits", "crash", "exit"),
        ("panics-in-new", "plugin", "panicked on purpose, in new"),
        ("panics-in-forces", "quarantine", "panicked on purpose"),
        ("forces-not-a-number", "quarantine", "forces-not-a-number"),
    ] {
        let bench = faulty_bench(fault, "");
        run_batch(&bench, &["--out", "out", "--isolate"]).expect(1);
        expect_failed(&bench, class, said);
    }
}

#[test]
fn after_a_crash_what_was_under_way_goes_on_in_a_child() {
    let bench = faulty_bench("aborts", "");
    // In this process the plugin takes the whole batch along.
    let mut code = run_batch(&bench, &["--out", "out", "--jobs", "1"]).code;
    assert_eq!(code, -1, "ended by a signal");
    for _ in 0..2 {
        code = run_batch(&bench, &["--out", "out", "--jobs", "1", "--resume"]).code;
    }
    assert_eq!(code, 1, "it came through");
    expect_failed(&bench, "crash", "signal 6 (abort)");
}

#[test]
#[cfg(target_os = "linux")]
fn an_edit_that_wants_too_much_memory_is_a_row() {
    let bench = small_bench(1, "[limits]\nmemory = \"200 MB\"\nseconds = \"300 s\"\n");
    // Some 4 GiB of triangles.
    let sweep = small_sweep(1, "[limits]\nmemory = \"200 MB\"\nseconds = \"300 s\"\n").replace(
        "path = \"tool.0.radius\"\nlist = [\"3 mm\", \"4 mm\", \"5 mm\"]",
        "path = \"body.0.shape.cells\"\nlist = [4, 4096]",
    );
    bench.write("sweep.toml", sweep);
    run_batch(&bench, &["--out", "out", "--jobs", "1"]).expect(1);
    let rows = rows(&bench, "out");
    assert_eq!(
        (&rows[0]["status"], &rows[1]["class"]),
        (&Value::from("done"), &Value::from("memory-limit")),
        "{rows:?}"
    );
}

#[test]
fn a_changed_mesh_is_done_again_and_the_rest_is_not() {
    let bench = Bench::new();
    bench.write("scene.toml", small_scene());
    for (name, detail) in [("a", "2"), ("b", "1")] {
        bench
            .pliant(&["sample", "elephant", "-o", &format!("models/{name}.obj"), "--detail", detail, "--force"])
            .expect(0);
    }
    bench.write("sweep.toml", "format = 1\nscene = \"scene.toml\"\nmodels = \"models/*.obj\"\n");
    run_batch(&bench, &["--out", "out"]).expect(0);
    let before = rows(&bench, "out");
    bench.pliant(&["sample", "elephant", "-o", "models/b.obj", "--detail", "3", "--force"]).expect(0);
    let again = run_batch(&bench, &["--out", "out", "--resume", "--json"]).expect(0).json();
    assert_eq!((&again["new"], &again["outdated"]), (&Value::from(1), &Value::from(1)));
    let after = rows(&bench, "out");
    assert_eq!(before[0], after[0]);
    assert!(before[1]["key"] != after[1]["key"] && before[1]["deepest"] != after[1]["deepest"]);
}

/// Runs a sweep in this process as another version of the program.
fn run_version(bench: &Bench, out: &str, program: &str, shard: &str, resume: bool) -> pliant_batch::BatchSummary {
    let plugins = pliant_tests::built(&pliant_tests::native::file_name("pliant_mass_spring"));
    let search = SearchPath::new(&[plugins.parent().expect("in a folder").to_path_buf()]);
    let shard = shard.parse().unwrap();
    let options = RunOptions { program: program.into(), shard, resume, jobs: 2, ..RunOptions::new(search) };
    let sweep = Sweep::read(&bench.path("sweep.toml")).unwrap_or_else(|e| panic!("{e}"));
    run(sweep, &bench.path(out), options, &mut |_| ()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn rows_of_another_version_are_done_again_and_not_mixed() {
    let bench = small_bench(2, "");
    run_version(&bench, "out", "pliant 9.1", "1/2", false);
    run_version(&bench, "out", "pliant 9.2", "2/2", false);
    bench.pliant(&["batch", "collect", "out"]).expect(2).says(&["results of pliant 9.2", "pliant 9.1", "--mixed"]);
    bench.pliant(&["batch", "collect", "out", "--mixed", "--output", "mixed.csv"]).expect(0);
    let mixed = String::from_utf8(bench.read("mixed.csv")).unwrap();
    let versions = ["9.1", "9.2"].map(|version| mixed.lines().filter(|line| line.ends_with(version)).count());
    assert_eq!(versions, [3, 3]);
    let end = run_version(&bench, "out", "pliant 9.2", "1/2", true);
    assert_eq!((end.new, end.outdated), (3, 3));
    bench.pliant(&["batch", "collect", "out"]).expect(0).says(&["6 of 6 runs"]);
}

/// Starts a batch whose first edits hang, so that it holds its shard.
fn start_hanging(bench: &Bench) -> Child {
    let mut command: Command = bench.command(&["batch", "sweep.toml", "--quiet", "--out", "out"]);
    let child = command.stderr(Stdio::null()).spawn().unwrap();
    wait_until("it holds its shard", || {
        bench.path("out/shard-1-of-1.journal").exists()
            && bench.pliant(&["batch", "status", "out", "--json"]).expect(0).json()[0]["state"] == "running"
    });
    child
}

#[test]
fn two_processes_do_not_run_one_shard() {
    let bench = faulty_bench("hangs", "");
    let mut child = start_hanging(&bench);
    let holder = format!("process {}", child.id());
    run_batch(&bench, &["--out", "out", "--resume"]).expect(2).says(&["shard 1/1 is being run by", &holder]);
    let shards = bench.pliant(&["batch", "status", "out", "--json"]).expect(0).json();
    assert_eq!(shards[0]["state"], "running");
    child.kill().unwrap();
    child.wait().unwrap();
    let shards = bench.pliant(&["batch", "status", "out", "--json"]).expect(0).json();
    assert_eq!(shards[0]["state"], "killed");
}

#[test]
#[cfg(unix)]
fn an_interrupt_ends_what_is_under_way_and_keeps_the_rest() {
    let bench = small_bench(40, "");
    run_batch(&bench, &["--out", "whole"]).expect(0);
    let mut command = bench.command(&["batch", "sweep.toml", "--quiet", "--out", "out", "--jobs", "1"]);
    let mut child = command.spawn().unwrap();
    let began = Instant::now();
    let rows_so_far = || std::fs::read(bench.path("out/shard-1-of-1.rows")).map_or(0, |b| b.len());
    while rows_so_far() == 0 && began.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let status = child.wait().unwrap();
    // A fast machine may have been done by then.
    assert!(matches!(status.code(), Some(130 | 0)), "{status:?}");
    assert!(!rows(&bench, "out").is_empty());
    run_batch(&bench, &["--out", "out", "--resume"]).expect(0);
    assert_eq!(bench.read("out/results.csv"), bench.read("whole/results.csv"));
}

#[test]
#[cfg(unix)]
fn a_full_disk_stops_a_batch_that_then_goes_on() {
    let bench = small_bench(10, "");
    run_batch(&bench, &["--out", "whole"]).expect(0);
    // No file may grow over 4 blocks of 1 KiB, which a write that would says as a full disk does.
    let program = pliant_tests::program();
    let script = "trap '' XFSZ; ulimit -f 4; exec \"$0\" batch sweep.toml --quiet --out out";
    let ran = bench.command(&[]);
    let mut command = Command::new("bash");
    command.args(["-c", script]).arg(&program).current_dir(ran.get_current_dir().unwrap());
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("out/shard-1-of-1.") && said.contains("File too large"), "{said}");
    let kept = rows(&bench, "out").len();
    assert!(kept < 30, "{kept} rows");
    run_batch(&bench, &["--out", "out", "--resume"]).expect(0);
    assert_eq!(bench.read("out/results.csv"), bench.read("whole/results.csv"));
}

#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_cannot_be_written_is_said_at_once() {
    let bench = small_bench(2, "");
    // Not even root may make a folder there.
    run_batch(&bench, &["--out", "/proc/batch"]).expect(2).says(&["/proc/batch"]);
    bench.write("file", "");
    run_batch(&bench, &["--out", "file"]).expect(2).says(&["file"]);
}
