//! Sweeps: shards that are run, and tables that are collected.

use super::failure::{Failure, Kind, contained};
use super::law::check_signals;
use pliant_batch::{
    BatchError, BatchSummary, CollectOptions, Format, Isolation, Progress, RunOptions, Shard, Sweep, collect, run,
    serve,
};
use pliant_host::{AllowedFolders, SearchPath};
use pyo3::prelude::*;
use serde_json::{Value, json};
use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::Ordering;

impl From<BatchError> for Failure {
    fn from(error: BatchError) -> Self {
        match error {
            BatchError::Sweep(error) => error.into(),
            BatchError::Io { ref path, .. } => {
                let place = path.display().to_string();
                Self::new(Kind::File, error).at(place)
            }
            BatchError::Locked { .. } => Self::new(Kind::Busy, error),
            error => Self::argument(error),
        }
    }
}

/// How a shard is run.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ShardOptions {
    /// As `I/N`.
    shard: String,
    /// Edits at a time; 0 takes what the machine has.
    jobs: usize,
    resume: bool,
    retry_failed: bool,
    isolate: bool,
    /// Folders that are searched for plugins first.
    plugin_path: Vec<PathBuf>,
    /// Folders from which scenes may name libraries by path.
    allow_plugins: Vec<PathBuf>,
    /// Folder of the plugins that come with the package.
    package_plugins: PathBuf,
    /// Program and arguments that do edits in a child process.
    child: Vec<String>,
}

impl ShardOptions {
    fn to_engine(&self) -> Result<RunOptions, Failure> {
        let shard: Shard = self.shard.parse().map_err(|why| Failure::argument(format!("shard {why}")))?;
        let allowed = AllowedFolders::new(&self.allow_plugins)?;
        let search = SearchPath::in_package(&self.plugin_path, &self.package_plugins).allow(allowed);
        let words = self.child.clone();
        let isolation = Isolation::new(move || {
            let mut command = Command::new(&words[0]);
            command.args(&words[1..]);
            command
        });
        Ok(RunOptions {
            shard,
            jobs: self.jobs,
            resume: self.resume,
            retry_failed: self.retry_failed,
            isolate: self.isolate,
            isolation: (!self.child.is_empty()).then_some(isolation),
            ..RunOptions::new(search)
        })
    }
}

/// Number of runs of a sweep.
#[pyfunction]
pub fn batch_size(py: Python<'_>, sweep: PathBuf) -> PyResult<u64> {
    Ok(py.detach(|| contained(|| Ok(Sweep::read(&sweep)?.edits())))?)
}

/// Executes a shard of a sweep into a folder and returns a summary as JSON. `progress` gets the numbers of runs that are done, that failed, and of
/// all, several times a second. Ctrl-C, or an exception of `progress`, ends runs under way and keeps the rest.
#[pyfunction]
#[pyo3(signature = (sweep, folder, options, progress=None))]
pub fn batch_run(
    py: Python<'_>,
    sweep: PathBuf,
    folder: PathBuf,
    options: ShardOptions,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let mut raised = None;
    let end: Result<BatchSummary, Failure> = py.detach(|| {
        contained(|| {
            let options = options.to_engine()?;
            let stop = options.stop.clone();
            let mut tell = |now: Progress| {
                let told = Python::attach(|py| {
                    check_signals(py)?;
                    let Some(progress) = &progress else { return Ok(()) };
                    progress.call1(py, (now.done, now.failed, now.edits)).map(drop)
                });
                if let Err(error) = told {
                    raised.get_or_insert(error);
                    stop.store(true, Ordering::Relaxed);
                }
            };
            Ok(run(Sweep::read(&sweep)?, &folder, options, &mut tell)?)
        })
    });
    match raised {
        Some(error) => Err(error),
        None => Ok(json!(end?).to_string()),
    }
}

/// Does edits that standard input names, one after another, and answers on standard output: the child process of a run.
#[pyfunction]
pub fn batch_serve(py: Python<'_>, sweep: PathBuf, folder: PathBuf, options: ShardOptions) -> PyResult<()> {
    let work = || {
        let (sweep, options) = (Sweep::read(&sweep)?, options.to_engine()?);
        #[cfg(unix)]
        pliant_host::end_with_parent(std::os::unix::process::parent_id());
        if let Some(bytes) = sweep.limits.memory {
            pliant_batch::limit_memory(bytes)?;
        }
        Ok(serve(&sweep, &folder, &options, std::io::stdin().lock(), &mut std::io::stdout().lock())?)
    };
    Ok(py.detach(|| contained(work))?)
}

/// Shards in some folders as one table, as JSON: columns with names, units and kinds, rows in the order of the sweep, and what is missing.
/// With `output` the table is written there too: CSV or JSON lines, by the end of its name.
#[pyfunction]
#[pyo3(signature = (folders, output, mixed, timings))]
pub fn batch_collect(
    py: Python<'_>,
    folders: Vec<PathBuf>,
    output: Option<PathBuf>,
    mixed: bool,
    timings: bool,
) -> PyResult<String> {
    let work = || {
        let mut collected = collect(&folders, CollectOptions { mixed, timings })?;
        if let Some(path) = output {
            let format = Format::of(&path).map_err(Failure::argument)?;
            let mut file = BufWriter::new(File::create(&path)?);
            collected.table.write(format, &mut file)?;
            std::io::Write::flush(&mut file)?;
        }
        let mut rows = Vec::new();
        collected.table.for_each(|cells| {
            rows.push(Value::from(cells));
            Ok(())
        })?;
        let (edits, failed, missing) = (collected.edits, collected.failed, &collected.missing);
        let columns = collected.table.columns();
        Ok(json!({ "columns": columns, "rows": rows, "edits": edits, "failed": failed, "missing": missing })
            .to_string())
    };
    Ok(py.detach(|| contained(work))?)
}
