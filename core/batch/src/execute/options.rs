//! Options, progress and result of a run.

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
    /// Number of parallel edits; 0 for the number of processors.
    pub jobs: usize,
    /// Whether more edits than processors, or than fit into memory, run at a time if asked for.
    pub oversubscribe: bool,
    /// Largest memory of all parallel edits, and of each if the sweep has no limit for it.
    pub memory: MemoryBudget,
    /// Whether a shard that has rows is completed; otherwise it is refused.
    pub resume: bool,
    /// Whether failed edits are run again.
    pub retry_failed: bool,
    /// Whether every edit runs in a child process.
    pub isolate: bool,
    /// How child processes are started; `None` allows no isolation.
    pub isolation: Option<Isolation>,
    /// Set it to stop the run: running edits then end without a row.
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

    /// Number of parallel edits that is asked for.
    pub(super) fn jobs_asked(&self) -> usize {
        if self.jobs == 0 { processors() } else { self.jobs }
    }

    /// Largest number of parallel edits: what is asked for, and without [`RunOptions::oversubscribe`] at most the number of processors.
    pub(crate) fn jobs(&self) -> usize {
        if self.oversubscribe { self.jobs_asked() } else { self.jobs_asked().min(processors()) }
    }
}

/// Progress of a shard.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Number of edits of the shard.
    pub edits: u64,
    /// Number of edits with a row, including failed ones and those of earlier runs.
    pub done: u64,
    /// Number of failed edits.
    pub failed: u64,
    /// Number of edits completed in this run.
    pub new: u64,
    /// Time since this run began, s.
    pub elapsed: f64,
}

impl Progress {
    /// Edits completed per second in this run.
    pub fn rate(&self) -> f64 {
        if self.elapsed > 0.0 { self.new as f64 / self.elapsed } else { 0.0 }
    }

    /// Estimated time to the end at the current rate, s; `None` before the first edit is complete.
    pub fn seconds_left(&self) -> Option<f64> {
        (self.new > 0).then(|| (self.edits - self.done) as f64 / self.rate())
    }
}

/// Result of a run of a shard.
#[derive(Clone, Debug, Default, Serialize)]
pub struct BatchSummary {
    /// Number of edits of the shard.
    pub edits: u64,
    /// Number of edits with a row.
    pub done: u64,
    /// Number of failed edits.
    pub failed: u64,
    /// Number of edits completed by this run.
    pub new: u64,
    /// Number of rows from before that are invalid because their scene, a file of it or the program has changed.
    pub outdated: u64,
    /// Whether the run was stopped before the last edit.
    pub stopped: bool,
    /// Number of threads that were abandoned in a plugin call that did not return.
    pub abandoned: usize,
    /// Wall-clock time of the run, s.
    pub elapsed: f64,
    /// Time of the steps of all edits of this run, s.
    pub step_seconds: f64,
    /// Total time of all edits of this run, s.
    pub edit_seconds: f64,
    /// Number of parallel edits that was asked for; that of the processors where none was.
    pub jobs_asked: usize,
    /// Number of parallel edits.
    pub jobs: usize,
    /// Number of processors, if no more edits run at a time for want of more; `None` if that is not less than what was asked for.
    pub jobs_on_processors: Option<usize>,
    /// Fewest edits at a time beyond which one waited for memory; `None` if none did.
    pub jobs_in_memory: Option<usize>,
    /// Memory of an edit: the sweep's limit, or the largest estimate so far, bytes.
    pub edit_memory: u64,
    /// Number of further workers for which the system gave no thread.
    pub refused: usize,
}
