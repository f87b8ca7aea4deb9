//! Every operation on files of a run and of a batch may fail, or be the last: the results are those of before or the new ones, nothing of the
//! user's is lost, the error names the file, and the next command makes everything whole.
//!
//! A tenth of the faults is tried by default; `FAULTS=0..2000` tries those with these numbers.

#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

use pliant_mesh::testing::Random;
use pliant_tests::batch::{small_bench, small_scene};
use pliant_tests::faults::{FileFault, run_with_fault};
use pliant_tests::result_sets::{FileSet, files, set_of};
use pliant_tests::{Bench, Ran, asked_cases};
use std::path::Path;

const KINDS: [&str; 3] = ["kill", "EIO", "ENOSPC"];
/// One of so many faults is tried by default.
const SHARE: f64 = 0.1;

const OLD: [&str; 6] = ["run", "scene.toml", "-q", "--set", "output.frames=4", "--out=out"];
const NEW: [&str; 8] = [
    "run",
    "scene.toml",
    "-q",
    "--set=output.forces=true",
    "--set=tool.0.radius=0.005",
    "--record",
    "hand.rec",
    "--out=out",
];

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in from.read_dir().expect("a folder").flatten() {
        match entry.file_type().expect("known").is_dir() {
            true => copy_folder(&entry.path(), &to.join(entry.file_name())),
            false => _ = std::fs::copy(entry.path(), to.join(entry.file_name())).expect("copied"),
        }
    }
}

/// A copy of a bench.
fn copy_of(bench: &Bench) -> Bench {
    let copy = Bench::new();
    copy_folder(&bench.path(""), &copy.path(""));
    copy
}

/// The faults to be tried of `operations` operations: numbers of all cases before are `first`.
fn faults(first: u64, operations: usize) -> Vec<FileFault> {
    let (asked, mut random) = (asked_cases("FAULTS"), Random(first + 16));
    let all = (1..=operations).flat_map(|at| KINDS.map(|how| FileFault { at, how }));
    let is_tried = |number: u64, draw: f64| asked.as_ref().map_or(draw < SHARE, |asked| asked.contains(&number));
    all.zip(first..).filter(|(_, number)| is_tried(*number, random.unit())).map(|(fault, _)| fault).collect()
}

/// Whether an error names the file of an operation or a folder of the results that it is in; temporary files have the name of what they become before
/// `.pliant-`.
fn names_the_file(text: &str, operation: &str) -> bool {
    let (_, path) = operation.split_once(' ').expect("a name and a path");
    let is_word = |name: &str| {
        let ends = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
        let parts = |at: usize| (text[..at].chars().next_back(), text[at + name.len()..].chars().next());
        text.match_indices(name).any(|(at, _)| ends(parts(at).0) && ends(parts(at).1))
    };
    let names = Path::new(path).components().rev().take(3).map(|part| part.as_os_str().to_string_lossy().into_owned());
    // The folder of the test is in every absolute path.
    let names = names.filter(|name| !name.starts_with(".tmp"));
    path == "." || names.into_iter().any(|name| is_word(name.split(".pliant-").next().unwrap_or(&name)))
}

/// Checks how a program with a fault at an operation ended. Its list of operations may have that operation up to `apart` places further on or before, where
/// threads take turns.
fn check_end(case: &str, ran: &Ran, fault: FileFault, operations: &[String], apart: usize) {
    let operation = operations.get(fault.at - 1);
    match (fault.how, ran.code, operation) {
        ("kill", -1, Some(_)) | (_, 0, None) => {}
        ("kill", code, _) => panic!("{case}: ended with {code} by itself: {}", ran.err),
        // What fails is not needed, as the flush of a folder.
        (_, 0, Some(_)) => {}
        (_, 2, Some(operation)) => {
            let (first, end) = ((fault.at - 1).saturating_sub(apart), (fault.at + apart).min(operations.len()));
            let is_named = operations[first..end].iter().any(|operation| names_the_file(&ran.err, operation));
            assert!(is_named, "{case}: `{operation}`: {}", ran.err);
        }
        (_, code, operation) => panic!("{case}: exit code {code} after {operation:?}: {}", ran.err),
    }
}

/// Results in `out`, without what the user has put there.
fn results(bench: &Bench) -> FileSet {
    let mut set = if bench.path("out").exists() { set_of(bench, "out") } else { FileSet::new() };
    set.retain(|name, _| !name.contains("mine") && !name.contains(".pliant-"));
    set
}

/// What is there before a run with a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Start {
    /// No folder of results.
    Nothing,
    /// Results of another scene, so that folders are exchanged.
    Results,
    /// The same with a file of the user's in their folder, so that files are moved one by one.
    ResultsAndMine,
}

fn run_bench(start: Start) -> Bench {
    let bench = Bench::new();
    bench.write("scene.toml", small_scene());
    bench.write("mine.txt", "mine");
    if start != Start::Nothing {
        bench.pliant(&OLD).expect(0);
    }
    if start == Start::ResultsAndMine {
        bench.write("out/mine.txt", "mine");
        bench.write("out/mine/final.obj", "mine");
    }
    bench
}

#[test]
fn a_run_with_a_fault_at_any_operation_leaves_one_set_of_results() {
    let (mut first, mut tried, mut unneeded, mut refused) = (0, 0, 0, 0);
    for start in [Start::Nothing, Start::Results, Start::ResultsAndMine] {
        let from = run_bench(start);
        let old = results(&from);
        let sound = copy_of(&from);
        let (ran, operations) = run_with_fault(&sound, &NEW, None);
        ran.expect(0);
        let (new, names) = (results(&sound), sound.names("."));
        assert!(new.len() > 3 && new != old && operations.len() > 20, "{operations:?}");
        let mine = |bench: &Bench| -> FileSet {
            files(bench, ".")
                .into_iter()
                .filter(|(name, _)| name.contains("mine") || name.ends_with("scene.toml"))
                .collect()
        };
        let users = mine(&from);
        for fault in faults(first, operations.len()) {
            let case = format!("{start:?}, {fault:?}, `{}`", operations[fault.at - 1]);
            let bench = copy_of(&from);
            let (ran, met) = run_with_fault(&bench, &NEW, Some(fault));
            check_end(&case, &ran, fault, &met, 0);
            let found = results(&bench);
            let is_whole = found == old || found == new;
            // Files that are moved one by one are a set once there is a summary.
            let is_moved = start == Start::ResultsAndMine && !found.contains_key("/summary.json");
            assert!(is_whole || is_moved, "{case}: a mix: {:?}", found.keys());
            assert!(ran.code != 0 || found == new, "{case}: not the new results, and no word of it");
            assert!(mine(&bench) == users, "{case}: {:?}", bench.names("out"));
            let recording = std::fs::read(bench.path("hand.rec")).ok();
            bench.pliant(&NEW).expect(0);
            assert!(results(&bench) == new, "{case}: the next run leaves its results");
            assert!(mine(&bench) == users && bench.names(".") == names, "{case}: {:?}", bench.names("."));
            let is_recording = recording.is_none_or(|recording| recording == bench.read("hand.rec"));
            assert!(is_recording, "{case}: the recording is whole or not there");
            tried += 1;
            unneeded += usize::from(ran.code == 0);
            refused += usize::from(ran.code == 2);
        }
        first += (KINDS.len() * operations.len()) as u64;
    }
    println!("{tried} of {first} faults: {unneeded} at operations that may fail, {refused} errors");
    assert!(asked_cases("FAULTS").is_some() || (tried > 10 && refused > 5), "{tried}, {refused}");
}

#[test]
fn a_batch_with_a_fault_at_any_operation_is_resumed_to_the_same_table() {
    let from = small_bench(1, "[keep]\nmeshes = true\n");
    from.write("mine.txt", "mine");
    let batch = ["batch", "sweep.toml", "--quiet", "--jobs", "1", "--out", "out"];
    let sound = copy_of(&from);
    let (ran, operations) = run_with_fault(&sound, &batch, None);
    ran.expect(0);
    let (table, names) = (sound.read("out/results.csv"), sound.names("out"));
    assert!(operations.len() > 20, "{operations:?}");
    let (mut tried, mut refused) = (0, 0);
    for fault in faults(0, operations.len()) {
        let case = format!("{fault:?}, `{}`", operations[fault.at - 1]);
        let bench = copy_of(&from);
        let (ran, met) = run_with_fault(&bench, &batch, Some(fault));
        if ran.code != 1 {
            check_end(&case, &ran, fault, &met, 2);
        }
        let is_there = bench.path("out/results.csv").exists();
        // A mesh that cannot be written is the failure of its edit.
        assert!(!is_there || ran.code == 1 || bench.read("out/results.csv") == table, "{case}: the table is whole");
        assert!(ran.code != 0 || is_there, "{case}: no table, and no word of it");
        bench.pliant(&[&batch[..], &["--resume", "--retry-failed"]].concat()).expect(0);
        assert!(bench.read("out/results.csv") == table, "{case}: the table after it is resumed");
        assert!(bench.names("out") == names && bench.read("mine.txt") == b"mine", "{case}: {:?}", bench.names("out"));
        tried += 1;
        refused += usize::from(ran.code > 0);
    }
    println!("{tried} of {} faults, {refused} errors", KINDS.len() * operations.len());
    assert!(asked_cases("FAULTS").is_some() || (tried > 5 && refused > 1), "{tried}, {refused}");
}
