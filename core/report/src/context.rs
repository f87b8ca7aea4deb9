//! Options of a report, and the shared state of its runs.

use crate::clock::{BusyTime, Clock};
use crate::scene_run::RunResult;
use pliant_engine::session::CancelToken;
use pliant_host::SearchPath;
use std::collections::BTreeSet;

/// Options of a report.
pub struct ReportOptions {
    /// Folders in which plugins are searched for.
    pub search: SearchPath,
    /// Number of threads of a run; a performance report also tries others.
    pub threads: usize,
    /// Whether to run fewer resolutions, so that the report takes about a minute.
    pub quick: bool,
    /// Only cases whose name contains one of these are run; all if empty.
    pub cases: Vec<String>,
    /// Seed of the order in which timed runs are interleaved.
    pub seed: u64,
    /// Clocks that runs are timed with.
    pub clock: Clock,
}

/// Progress of a report.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// Number of completed runs.
    pub done: usize,
    /// Number of all runs.
    pub total: usize,
    /// The next run: case, method, resolution.
    pub what: &'a str,
}

/// State of a report in progress: its options, its callbacks, and totals over its runs.
pub struct ReportContext<'a> {
    pub(crate) options: ReportOptions,
    progress: &'a mut dyn FnMut(Progress<'_>),
    stop: CancelToken,
    plugins: BTreeSet<String>,
    busy: BusyTime,
}

impl<'a> ReportContext<'a> {
    /// A report without runs. `progress` is called before each run. When `stop` is cancelled the step under way ends, its run does not count,
    /// and no further run begins.
    pub fn new(options: ReportOptions, progress: &'a mut dyn FnMut(Progress<'_>), stop: CancelToken) -> Self {
        Self { options, progress, stop, plugins: BTreeSet::new(), busy: BusyTime::default() }
    }

    /// Whether a case is selected.
    pub fn wants(&self, case: &str) -> bool {
        let names = &self.options.cases;
        names.is_empty() || names.iter().any(|name| case.contains(name.as_str()))
    }

    /// Whether the report is to stop.
    pub fn is_stopped(&self) -> bool {
        self.stop.is_cancelled()
    }

    /// What ends the step under way.
    pub(crate) fn stop(&self) -> CancelToken {
        self.stop.clone()
    }

    /// Reports the next run to the caller.
    pub(crate) fn announce(&mut self, done: usize, total: usize, what: &str) {
        (self.progress)(Progress { done, total, what });
    }

    /// Adds the plugins and the time of a run.
    pub(crate) fn add_run(&mut self, result: &RunResult) {
        self.plugins.extend(result.plugins.iter().cloned());
        self.busy.thread_wall += result.wall * result.choices.threads as f64;
        self.busy.cpu += result.cpu;
    }

    /// Plugins of all runs so far, with their versions.
    pub(crate) fn plugins(&self) -> &BTreeSet<String> {
        &self.plugins
    }

    /// Time of all runs so far.
    pub(crate) fn busy(&self) -> BusyTime {
        self.busy
    }
}
