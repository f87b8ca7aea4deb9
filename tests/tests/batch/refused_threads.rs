//! Numbers of threads that no machine has are refused, and without threads to be had a run goes on with fewer, with a warning and the same bytes.

#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

use pliant_tests::batch::{small_scene, small_sweep};
use pliant_tests::faults::with_threads;
use pliant_tests::{Bench, Ran, box_scene, warning_codes};

/// A scene whose body has enough elements for all threads.
fn scene() -> String {
    box_scene("", "", "")
        .replace("level = 5 }", "level = 5, region = \"whole\" }")
        .replace("duration = 0.05", "duration = 0.03")
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("scene.toml", scene());
    bench.write("small.toml", small_scene());
    bench.write("sweep.toml", small_sweep(1, "").replace("scene.toml", "small.toml"));
    bench
}

/// Runs `pliant` with `threads` threads besides the first.
fn run_with(bench: &Bench, args: &[&str], threads: usize) -> Ran {
    Ran::from(with_threads(bench.command(args), threads).output().expect("the program starts"))
}

#[test]
fn absurd_numbers_of_threads_are_refused_by_every_verb() {
    let bench = bench();
    let verbs: [&[&str]; 5] = [
        &["run", "scene.toml", "--threads"],
        &["replay", "hand.rec", "--threads"],
        &["report", "accuracy", "--threads"],
        &["edit", "scene.toml", "--threads"],
        &["batch", "sweep.toml", "--jobs"],
    ];
    for verb in verbs {
        for absurd in ["18446744073709551615", "18446744073709551616", "100000", "1025", "two"] {
            let refused = bench.pliant(&[verb, &[absurd]].concat()).expect(2);
            refused.says(&[absurd, "allowed is 0 to 1024"]);
        }
    }
    bench.pliant(&["plan", "small.toml", "--threads", "1024", "--oversubscribe"]).expect(0);
    for allowed in ["0", "1", "16"] {
        bench.pliant(&["run", "scene.toml", "-q", "--oversubscribe", "--threads", allowed, "--out", allowed]).expect(0);
        assert!(bench.read(&format!("{allowed}/final.obj")) == bench.read("0/final.obj"), "{allowed}");
    }
}

#[test]
fn a_run_without_threads_goes_on_alone_and_says_so() {
    let bench = bench();
    let all = ["run", "scene.toml", "-q", "--oversubscribe", "--threads", "4", "--out"];
    bench.pliant(&[&all[..], &["whole"]].concat()).expect(0);
    assert_eq!(warning_codes(&bench.summary("whole")), [""; 0]);
    let mut warned = 0;
    for threads in 0..=7 {
        let out = format!("out-{threads}");
        run_with(&bench, &[&all[..], &[&out]].concat(), threads).expect(0);
        let summary = bench.summary(&out);
        assert!(bench.read(&format!("{out}/final.obj")) == bench.read("whole/final.obj"), "{threads}");
        assert_eq!(summary["inputs"], bench.summary("whole")["inputs"], "{threads}: digests do not need a thread");
        let alone = summary["choices"]["threads"] == 1;
        let expected: &[&str] = if alone { &["fewer-threads"] } else { &[] };
        assert_eq!(warning_codes(&summary), expected, "{threads}");
        assert!(alone || threads >= 3, "{threads}: three more are needed");
        warned += usize::from(alone);
    }
    assert!((1..8).contains(&warned), "some are enough: {warned}");
}

#[test]
fn other_verbs_end_in_good_order_without_threads() {
    let bench = bench();
    for threads in [0, 1, 2, 8] {
        let dir = |name: &str| format!("{name}-{threads}");
        run_with(&bench, &["plan", "scene.toml"], threads).expect(0);
        let ran = run_with(
            &bench,
            &["batch", "sweep.toml", "--jobs", "3", "--oversubscribe", "--out", &dir("batch")],
            threads,
        );
        match (threads, ran.code) {
            // One thread may be that of a watchdog.
            (0 | 1, 2) => ran.says(&["a thread cannot be started"]),
            (_, 0) if threads > 3 => ran.says(&["3 of 3 runs done"]),
            (_, 0) => ran.says(&["3 of 3 runs done", "warning: the system refused to start", "--jobs"]),
            _ => ran.expect(0),
        };
        let live = run_with(&bench, &["run", "scene.toml", "--live", "-q", "--out", &dir("live")], threads);
        assert!([0, 2, 3].contains(&live.code), "{threads}: {} {}", live.code, live.err);
        assert!(live.code == 0 || live.err.contains("thread cannot be started"), "{threads}: {}", live.err);
        let isolated = run_with(&bench, &["run", "scene.toml", "--isolate", "-q", "--out", &dir("isolated")], threads);
        assert!([0, 2, 3].contains(&isolated.code), "{threads}: {} {}", isolated.code, isolated.err);
        assert!(!live.err.contains("panicked") && !isolated.err.contains("panicked"), "{}{}", live.err, isolated.err);
    }
}
