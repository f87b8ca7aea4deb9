//! Progress of the shards of a batch.

use crate::error::BatchError;
use crate::store::{OpenRecord, journals, read_state};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

/// Progress of a shard.
#[derive(Clone, Debug, Serialize)]
pub struct ShardStatus {
    /// Path of its journal.
    pub journal: PathBuf,
    /// The shard, as `I/N`.
    pub shard: String,
    /// Title of the sweep.
    pub title: String,
    /// Program and version of its results.
    pub program: String,
    /// Number of its runs.
    pub edits: u64,
    /// Number of runs with a row.
    pub done: u64,
    /// Number of failed runs by class.
    pub failed: BTreeMap<String, u64>,
    /// Number of runs that began and have no row.
    pub under_way: u64,
    /// `running`, `finished`, `stopped` before its last run, or `killed`.
    pub state: &'static str,
    /// The process that runs it or ran it last.
    pub process: String,
    /// Total time of all runs with a row, s.
    pub edit_seconds: f64,
    /// Time of their steps, s.
    pub step_seconds: f64,
}

/// Progress of each shard in a folder, in the order of their names.
///
/// # Errors
/// Fails for a folder without shards and for a journal that cannot be read.
pub fn status(folder: &Path) -> Result<Vec<ShardStatus>, BatchError> {
    journals(folder)?.into_iter().filter_map(|path| of_shard(path).transpose()).collect()
}

/// Progress of the shard of a journal; `None` if no process has opened it yet.
fn of_shard(journal: PathBuf) -> Result<Option<ShardStatus>, BatchError> {
    let mut file = File::open(&journal).map_err(BatchError::at(&journal))?;
    let running = matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
    let _ = file.unlock();
    let state = read_state(&mut file, &journal)?;
    let Some(open) = &state.opened else { return Ok(None) };
    let OpenRecord { title, program, process, edits, .. } = open.clone();
    let edits = open.shard().len(edits);
    let mut failed = BTreeMap::new();
    for class in state.rows.values().filter_map(|row| row.failed) {
        *failed.entry(class.name().to_owned()).or_default() += 1;
    }
    let done = state.rows.len() as u64;
    Ok(Some(ShardStatus {
        journal,
        shard: open.shard().to_string(),
        title,
        program,
        edits,
        done,
        failed,
        under_way: state.under_way.len() as u64,
        state: match &state.closed {
            _ if running => "running",
            Some(_) if done == edits => "finished",
            Some(_) => "stopped",
            None => "killed",
        },
        process,
        edit_seconds: state.rows.values().map(|row| row.seconds.all).sum(),
        step_seconds: state.rows.values().map(|row| row.seconds.steps).sum(),
    }))
}
