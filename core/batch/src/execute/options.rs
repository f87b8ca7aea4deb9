//! What a caller decides of a run, and what it is told.

use super::child::Isolation;
use crate::shard::Shard;
use pliant_host::SearchPath;
use serde::Serialize;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What the caller decides.
#[derive(Clone)]
pub struct RunOptions {
    /// Where plugins are looked for.
    pub search: SearchPath,
    /// Program and version whose results these are; part of every key.
    pub program: String,
    /// The part of the sweep to do.
    pub shard: Shard,
    /// Number of edits at a time; 0 takes as many as the program may use processors.
    pub jobs: usize,
    /// Do what is missing of a shard that has rows already, instead of refusing it.
    pub resume: bool,
    /// Do failed edits again as well.
    pub retry_failed: bool,
    /// Run every edit in a child process.
    pub isolate: bool,
    /// How a child process is started; without it nothing can be isolated.
    pub isolation: Option<Isolation>,
    /// Set from outside to stop: edits under way end without a row.
    pub stop: Arc<AtomicBool>,
}

impl RunOptions {
    /// The whole sweep, in this process, on all processors, begun anew.
    pub fn new(search: SearchPath) -> Self {
        Self {
            search,
            program: format!("pliant {}", env!("CARGO_PKG_VERSION")),
            shard: Shard::default(),
            jobs: 0,
            resume: false,
            retry_failed: false,
            isolate: false,
            isolation: None,
            stop: Arc::default(),
        }
    }

    /// Number of edits at a time.
    pub(super) fn jobs(&self) -> usize {
        match self.jobs {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            jobs => jobs,
        }
    }
}

/// How far a shard is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Edits of the shard.
    pub edits: u64,
    /// Edits with a row, failed ones and those of earlier runs among them.
    pub done: u64,
    /// Edits whose row says that they failed.
    pub failed: u64,
    /// Edits done since this run began.
    pub new: u64,
    /// s, since this run began
    pub elapsed: f64,
}

impl Progress {
    /// Edits a second since this run began.
    pub fn rate(&self) -> f64 {
        if self.elapsed > 0.0 { self.new as f64 / self.elapsed } else { 0.0 }
    }

    /// s until the last edit at the rate so far; `None` before the first one
    pub fn seconds_left(&self) -> Option<f64> {
        (self.new > 0).then(|| (self.edits - self.done) as f64 / self.rate())
    }
}

/// How a run of a shard ended. Times are sums over the edits of this run.
#[derive(Clone, Debug, Default, Serialize)]
pub struct BatchEnd {
    /// Edits of the shard.
    pub edits: u64,
    /// Edits with a row.
    pub done: u64,
    /// Edits whose row says that they failed.
    pub failed: u64,
    /// Edits done by this run.
    pub new: u64,
    /// Rows of before that no longer counted, as their scene, a file of it, or the program has changed.
    pub outdated: u64,
    /// Whether it was stopped before the last edit.
    pub stopped: bool,
    /// Threads that were left behind in a plugin that did not return.
    pub abandoned: usize,
    /// s, wall clock
    pub elapsed: f64,
    /// s, of all edits, in steps
    pub step_seconds: f64,
    /// s, of all edits, altogether
    pub edit_seconds: f64,
    /// Number of edits at a time.
    pub jobs: usize,
}
