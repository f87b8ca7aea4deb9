//! Options, progress and result of a batch.

use super::admission::processors;
use super::child::Isolation;
use crate::shard::Shard;
use pliant_engine::memory::MemoryBudget;
use pliant_host::SearchPath;
use serde::Serialize;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Options of [`run`](super::run).
#[derive(Clone)]
pub struct RunOptions {
    /// Folders in which plugins are searched.
    pub search: SearchPath,
    /// Program and version of the results; part of every key.
    pub program: String,
    /// The part of the sweep to run.
    pub shard: Shard,
    /// Number of parallel runs; 0 for the number of processors.
    pub jobs: usize,
    /// Whether more runs than processors, or than fit into memory, are concurrent if asked for.
    pub oversubscribe: bool,
    /// Largest memory of all parallel runs, and of each if the sweep has no limit for it.
    pub memory: MemoryBudget,
    /// Whether a shard that has rows is completed; otherwise it is refused.
    pub resume: bool,
    /// Whether failed runs are repeated.
    pub retry_failed: bool,
    /// Whether every run has a child process.
    pub isolate: bool,
    /// How child processes are started; `None` allows no isolation.
    pub isolation: Option<Isolation>,
    /// Set it to stop the batch: runs in progress then end without a row.
    pub stop: Arc<AtomicBool>,
}

impl RunOptions {
    /// Defaults: the whole sweep, in this process, on all processors, without rows from before.
    pub fn new(search: SearchPath) -> Self {
        Self {
            search,
            program: format!("pliant {}", env!("CARGO_PKG_VERSION")),
            shard: Shard::default(),
            jobs: 0,
            oversubscribe: false,
            memory: MemoryBudget::default(),
            resume: false,
            retry_failed: false,
            isolate: false,
            isolation: None,
            stop: Arc::default(),
        }
    }

    /// Number of parallel runs that is asked for.
    pub(super) fn jobs_asked(&self) -> usize {
        if self.jobs == 0 { processors() } else { self.jobs }
    }

    /// Largest number of parallel runs: what is asked for, and without [`RunOptions::oversubscribe`] at most the number of processors.
    pub(crate) fn jobs(&self) -> usize {
        if self.oversubscribe { self.jobs_asked() } else { self.jobs_asked().min(processors()) }
    }
}

/// Progress of a shard.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Number of runs of the shard.
    pub edits: u64,
    /// Number of runs with a row, including failed ones and those of earlier batches.
    pub done: u64,
    /// Number of failed runs.
    pub failed: u64,
    /// Number of runs completed in this batch.
    pub new: u64,
    /// Time since this batch began, s.
    pub elapsed: f64,
}

impl Progress {
    /// Runs completed per second in this batch.
    pub fn rate(&self) -> f64 {
        if self.elapsed > 0.0 { self.new as f64 / self.elapsed } else { 0.0 }
    }

    /// Estimated time to the end at the current rate, s; `None` before the first run is complete.
    pub fn seconds_left(&self) -> Option<f64> {
        (self.new > 0).then(|| (self.edits - self.done) as f64 / self.rate())
    }
}

/// Result of a batch: the execution of a shard.
#[derive(Clone, Debug, Default, Serialize)]
pub struct BatchSummary {
    /// Number of runs of the shard.
    pub edits: u64,
    /// Number of runs with a row.
    pub done: u64,
    /// Number of failed runs.
    pub failed: u64,
    /// Number of runs completed by this batch.
    pub new: u64,
    /// Number of rows from before that are invalid because their scene, a file of it or the program has changed.
    pub outdated: u64,
    /// Whether the batch was stopped before the last run.
    pub stopped: bool,
    /// Number of threads that were abandoned in a plugin call that did not return.
    pub abandoned: usize,
    /// Wall-clock time of the batch, s.
    pub elapsed: f64,
    /// Time of the steps of all runs of this batch, s.
    pub step_seconds: f64,
    /// Total time of all runs of this batch, s.
    pub edit_seconds: f64,
    /// Number of parallel runs that was asked for; that of the processors where none was.
    pub jobs_asked: usize,
    /// Number of parallel runs.
    pub jobs: usize,
    /// Number of processors, if it limits the number of concurrent runs; `None` if it is not less than the number asked for.
    pub jobs_on_processors: Option<usize>,
    /// Smallest limit at which a run waited for memory; `None` if none did.
    pub jobs_in_memory: Option<usize>,
    /// Memory per run: the sweep's limit, or the largest estimate so far, bytes.
    pub edit_memory: u64,
    /// Number of further workers for which the system gave no thread.
    pub refused: usize,
}
