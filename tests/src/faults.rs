//! Faults of the system for a run of the program: threads that are refused, operations on files that fail or at which the process ends.
//!
//! A library written in C and built by the test is loaded into the program; its text (`faults/faults.c`) says which faults there are. It catches
//! system calls by their numbers, so it is for Linux on x86-64.

use crate::{Bench, Ran};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// A fault at one operation on files.
#[derive(Clone, Copy, Debug)]
pub struct FileFault {
    /// Which of the counted operations, from 1.
    pub at: usize,
    /// `kill`: the process ends before it; `EIO`: it fails; `ENOSPC`: it and all later ones that create or write fail.
    pub how: &'static str,
}

/// The library, built once for a test executable.
fn shim() -> &'static Path {
    static BUILT: OnceLock<(Bench, PathBuf)> = OnceLock::new();
    let (_, library) = BUILT.get_or_init(|| {
        let bench = Bench::new();
        let library = bench.compile("shim", "faults", include_str!("faults/faults.c"));
        (bench, library)
    });
    library
}

/// The same command, whose process has `threads` threads besides its first at most.
pub fn with_threads(mut command: Command, threads: usize) -> Command {
    command.env("LD_PRELOAD", shim()).env("FAULT_THREADS", threads.to_string());
    command
}

/// Runs a command with a fault, or with none, in a bench, and returns what the program said and the operations on files of the bench, each with its
/// file.
///
/// # Panics
/// If the program cannot be started, or the system does not let calls be caught.
pub fn run_with_fault(bench: &Bench, args: &[&str], fault: Option<FileFault>) -> (Ran, Vec<String>) {
    let log = tempfile::NamedTempFile::new().expect("a temporary file");
    let mut command = bench.command(args);
    command.env("LD_PRELOAD", shim()).env("FAULT_LOG", log.path()).env("FAULT_UNDER", bench.path(""));
    if let Some(FileFault { at, how }) = fault {
        command.env("FAULT_AT", at.to_string()).env("FAULT_HOW", how);
    }
    let ended = command.output().expect("the program starts");
    let text = String::from_utf8_lossy(&std::fs::read(log.path()).expect("the log")).into_owned();
    let ran = Ran::from(ended);
    assert_ne!(ran.code, 99, "{}", ran.err);
    (ran, text.lines().map(str::to_owned).collect())
}
