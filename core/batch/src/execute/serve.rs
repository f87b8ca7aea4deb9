//! The other side of [`Isolation`](super::Isolation): a child that does one edit after another.

use super::options::RunOptions;
use super::run_edit::{EditResult, EditRunner, MODELS_KEPT};
use crate::edit::Resolved;
use crate::error::BatchError;
use crate::key::{EditKey, KeyMaker};
use crate::store::MeshStore;
use crate::sweep::Sweep;
use pliant_engine::session::{CancelToken, SharedParts};
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead, Write};
use std::path::Path;
use std::time::Instant;

/// What a child answers, a line of JSON.
#[derive(Serialize, Deserialize)]
pub(super) struct Reply {
    key: EditKey,
    /// What the edit came to, or why the whole batch cannot go on.
    result: Result<EditResult, String>,
}

impl Reply {
    /// The result, if it is of the edit with this key.
    pub(super) fn result(self, key: &EditKey) -> Result<EditResult, BatchError> {
        if self.key != *key {
            let text = "the sweep or a file it names has changed since the batch began; start again with --resume";
            return Err(BatchError::Input(text.into()));
        }
        self.result.map_err(BatchError::Input)
    }
}

/// Reads places of edits from `input`, a line each, does them, and answers on `output`, until `input` ends.
///
/// # Errors
/// A line that is no place in the sweep, or an output that cannot be written.
pub fn serve(
    sweep: &Sweep,
    folder: &Path,
    options: &RunOptions,
    input: impl BufRead,
    output: &mut impl Write,
) -> io::Result<()> {
    let keys = KeyMaker::new(&options.program, &options.search);
    let meshes = MeshStore::new(folder);
    let parts = SharedParts::new(MODELS_KEPT);
    let runner =
        EditRunner { sweep, search: &options.search, meshes: &meshes, parts: &parts, cancel: CancelToken::default() };
    for line in input.lines() {
        let line = line?;
        let place = line.trim().parse().ok().filter(|place| *place < sweep.edits());
        let place = place.ok_or_else(|| io::Error::other(format!("`{line}` is no edit of the sweep")))?;
        let began = Instant::now();
        let resolved = Resolved::new(sweep, place, &keys);
        let result = runner.run(&resolved, began, &|| false);
        let result = result.map(|done| done.expect("nothing stops it")).map_err(|error| error.to_string());
        let reply = serde_json::to_string(&Reply { key: resolved.key, result })?;
        writeln!(output, "{reply}").and_then(|()| output.flush())?;
    }
    Ok(())
}

/// Limits the memory of this process to `bytes` more than it has now: an allocation over it fails.
///
/// # Errors
/// A system that knows no such limit.
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
