//! The child process of [`Isolation`](super::Isolation), which executes runs one after another.

use super::options::RunOptions;
use super::run_edit::{EditResult, EditRunner, MODELS_KEPT};
use crate::edit::Resolved;
use crate::error::BatchError;
use crate::key::{EditKey, KeyMaker};
use crate::store::MeshStore;
use crate::sweep::Sweep;
use pliant_engine::session::SharedParts;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::io::{self, BufRead, Write};
use std::path::Path;
use std::time::Instant;

/// A line of JSON from a child.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Line {
    /// The run is open.
    Opened {
        /// Its estimated memory, bytes.
        memory: u64,
    },
    /// The run has ended.
    Ended(Reply),
}

/// The reply of a child.
#[derive(Serialize, Deserialize)]
pub(super) struct Reply {
    /// Key of the run.
    key: EditKey,
    /// The result of the run, or an error that ends the batch.
    result: Result<EditResult, String>,
}

impl Reply {
    /// The result of the run with this key.
    ///
    /// # Errors
    /// Fails for another key, as the sweep has changed, and with the error of the child.
    pub(super) fn result(self, key: &EditKey) -> Result<EditResult, BatchError> {
        if self.key != *key {
            let text = "the sweep or a file it names has changed since the batch began; start again with --resume";
            return Err(BatchError::Input(text.into()));
        }
        self.result.map_err(BatchError::Input)
    }
}

/// Reads indices of runs from `input`, one on each line, executes the runs and writes replies to `output`, until `input` ends. Meshes are stored in
/// the batch `folder`.
///
/// # Errors
/// Fails for a line that is not an index of the sweep and for an output that cannot be written.
pub fn serve(
    sweep: &Sweep,
    folder: &Path,
    options: &RunOptions,
    input: impl BufRead,
    output: &mut impl Write,
) -> io::Result<()> {
    let output = RefCell::new(output);
    let write = |line: &Line| {
        let mut output = output.borrow_mut();
        writeln!(output, "{}", serde_json::to_string(line)?).and_then(|()| output.flush())
    };
    // A parent that has ended is noticed at the end of the run.
    let on_open = |memory: u64| _ = write(&Line::Opened { memory });
    let keys = KeyMaker::new(&options.program, &options.search);
    let meshes = MeshStore::new(folder);
    let parts = SharedParts::new(MODELS_KEPT);
    let runner = EditRunner::new(sweep, options, &meshes, &parts, &on_open);
    for line in input.lines() {
        let line = line?;
        let index = line.trim().parse().ok().filter(|index| *index < sweep.edits());
        let index = index.ok_or_else(|| io::Error::other(format!("`{line}` is not a run of the sweep")))?;
        let began = Instant::now();
        let resolved = Resolved::new(sweep, index, &keys);
        let result = runner.run(&resolved, began, &|| false);
        let result = result.map(|done| done.expect("it is not stopped")).map_err(|error| error.to_string());
        write(&Line::Ended(Reply { key: resolved.key, result }))?;
    }
    Ok(())
}

/// Limits the memory of this process to `bytes` more than it has now: allocations beyond it fail.
///
/// # Errors
/// The error of the system.
#[cfg(target_os = "linux")]
pub fn limit_memory(bytes: u64) -> io::Result<()> {
    use nix::sys::resource::{Resource, setrlimit};
    let status = std::fs::read_to_string("/proc/self/status")?;
    let size = status.lines().find_map(|line| line.strip_prefix("VmSize:")?.trim().strip_suffix("kB"));
    let kilobytes: u64 = size.and_then(|size| size.trim().parse().ok()).unwrap_or(0);
    let limit = kilobytes * 1024 + bytes;
    setrlimit(Resource::RLIMIT_AS, limit, limit).map_err(io::Error::from)
}

/// Limits the memory of this process: not possible on this system.
///
/// # Errors
/// Always.
#[cfg(not(target_os = "linux"))]
pub fn limit_memory(bytes: u64) -> io::Result<()> {
    Err(io::Error::other(format!("a limit of {bytes} bytes of memory cannot be set on this system")))
}
