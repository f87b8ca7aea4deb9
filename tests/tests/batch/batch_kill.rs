//! A batch that is killed at any moment loses what was under way and nothing else.

use pliant_mesh::testing::Random;
use pliant_tests::Bench;
use pliant_tests::batch::{run_batch, small_bench};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Kills in a test of every day; the environment's `PLIANT_KILLS` asks for more.
const KILLS: usize = 12;

/// Runs `pliant` with these arguments and kills it after a time, if it is not done by then; whether it was killed.
fn run_and_kill(bench: &Bench, args: &[&str], after: Duration) -> bool {
    let mut child = bench.command(args).spawn().unwrap();
    let began = Instant::now();
    while began.elapsed() < after {
        if child.try_wait().unwrap().is_some() {
            return false;
        }
        std::thread::sleep(Duration::from_micros(500));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    true
}

/// Checks that whatever can be read of the folder is whole: rows of the undisturbed table, and whole meshes.
fn check_whole(bench: &Bench, reference: &BTreeSet<String>) {
    if bench.names("out").iter().any(|name| name.ends_with(".journal")) {
        let ran = bench.pliant(&["batch", "collect", "out", "--output", "seen.csv"]);
        if ran.code == 0 {
            let seen = String::from_utf8(bench.read("seen.csv")).unwrap();
            for line in seen.lines() {
                assert!(reference.contains(line), "not a row of the undisturbed table: {line}");
            }
        } else {
            ran.expect(2).says(&["no shard has been begun"]);
        }
    }
    for folder in bench.names("out/meshes") {
        for name in bench.names(&format!("out/meshes/{folder}")).iter().filter(|name| !name.ends_with(".partial")) {
            let (path, whole) = (format!("out/meshes/{folder}/{name}"), format!("whole/meshes/{folder}/{name}"));
            assert_eq!(bench.read(&path), bench.read(&whole), "{path}");
        }
    }
}

#[test]
fn killed_at_any_moment_and_resumed_it_gives_the_undisturbed_table() {
    let kills = std::env::var("PLIANT_KILLS").ok().and_then(|kills| kills.parse().ok()).unwrap_or(KILLS);
    let bench = small_bench(12, "[keep]\nmeshes = true\n");
    let began = Instant::now();
    run_batch(&bench, &["--out", "whole", "--jobs", "2"]).expect(0);
    let whole = began.elapsed().as_secs_f64();
    let table = bench.read("whole/results.csv");
    let reference: BTreeSet<String> = String::from_utf8(table.clone()).unwrap().lines().map(str::to_owned).collect();
    let mut random = Random(1);
    let mut killed = 0;
    let mut rounds = 0;
    while killed < kills {
        // From before the first file to the collecting at the end; a batch is done after several kills.
        let after = Duration::from_secs_f64(whole * 1.1 * random.unit().powi(2));
        let args = ["batch", "sweep.toml", "--quiet", "--out", "out", "--jobs", "2", "--resume"];
        if run_and_kill(&bench, &args, after) {
            killed += 1;
            check_whole(&bench, &reference);
        } else {
            assert_eq!(bench.read("out/results.csv"), table, "after {killed} kills");
            std::fs::remove_dir_all(bench.path("out")).unwrap();
            rounds += 1;
        }
    }
    run_batch(&bench, &["--out", "out", "--jobs", "2", "--resume"]).expect(0);
    assert_eq!(bench.read("out/results.csv"), table, "after {killed} kills in {rounds} batches");
    let partial = bench
        .names("out/meshes")
        .iter()
        .flat_map(|f| bench.names(&format!("out/meshes/{f}")))
        .filter(|n| n.ends_with(".partial"))
        .count();
    assert_eq!(partial, 0, "leftovers of killed processes are removed");
}

#[test]
fn collecting_that_is_killed_leaves_the_old_table() {
    let bench = small_bench(12, "");
    run_batch(&bench, &["--out", "out"]).expect(0);
    let table = bench.read("out/results.csv");
    let mut random = Random(2);
    for _ in 0..KILLS {
        run_and_kill(&bench, &["batch", "collect", "out"], Duration::from_secs_f64(0.03 * random.unit()));
        assert_eq!(bench.read("out/results.csv"), table);
    }
}
