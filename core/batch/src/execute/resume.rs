//! Comparison of the rows of a shard with the sweep, for resuming.

use super::options::RunOptions;
use crate::column::row_json;
use crate::edit::Resolved;
use crate::error::BatchError;
use crate::key::{EditKey, KeyMaker};
use crate::store::{NewRow, RowRecord, ShardFiles, ShardState};
use crate::sweep::Sweep;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, HashMap};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A run without a row.
pub(super) struct MissingEdit {
    /// Index of the run.
    pub(super) index: u64,
    /// Number of attempts by a process that was killed.
    pub(super) attempts: u32,
}

/// State of a shard when it is resumed: its missing runs, and the numbers of its rows.
pub(super) struct ResumeState {
    /// Runs without a row, by ascending index.
    pub(super) edits: Vec<MissingEdit>,
    /// Number of runs with a row.
    pub(super) done: u64,
    /// Number of runs whose row is one of a failure.
    pub(super) failed: u64,
    /// Number of invalid rows.
    pub(super) outdated: u64,
}

/// Compares the rows of a shard with the current sweep. Rows of unchanged runs are valid; those whose run has another index now are written
/// again with it; all others are invalid.
pub(super) fn compare_with_sweep(
    sweep: &Sweep,
    keys: &KeyMaker,
    options: &RunOptions,
    files: &mut ShardFiles,
    state: ShardState,
) -> Result<ResumeState, BatchError> {
    let indices: Vec<u64> = options.shard.edits(sweep.edits()).collect();
    let mut resumed = ResumeState { edits: Vec::new(), done: 0, failed: 0, outdated: 0 };
    let is_retried = |row: &RowRecord| options.retry_failed && row.failed.is_some();
    let same_columns = state.opened.as_ref().is_none_or(|open| open.columns == sweep.columns());
    let known: HashMap<EditKey, RowRecord> = match same_columns {
        true => state.rows.values().filter(|row| !is_retried(row)).map(|row| (row.key.clone(), row.clone())).collect(),
        false => HashMap::new(),
    };
    let mut current = if known.is_empty() { BTreeMap::new() } else { keys_of(sweep, keys, &indices, options.jobs()) };
    let mut kept: BTreeMap<u64, RowRecord> = BTreeMap::new();
    for &index in &indices {
        let row = current.remove(&index).and_then(|key| known.get(&key));
        match row {
            None => {
                let attempts = state.under_way.get(&index).copied().unwrap_or(0);
                resumed.edits.push(MissingEdit { index, attempts });
            }
            Some(row) => {
                resumed.failed += u64::from(row.failed.is_some());
                kept.insert(index, row.clone());
            }
        }
    }
    resumed.done = kept.len() as u64;
    let valid: std::collections::HashSet<&EditKey> = kept.values().map(|row| &row.key).collect();
    resumed.outdated = state.rows.values().filter(|row| !is_retried(row) && !valid.contains(&row.key)).count() as u64;
    for (index, row) in &kept {
        if row.edit != *index {
            move_row(sweep, *index, row, files)?;
        }
    }
    for index in state.rows.keys().filter(|index| !kept.contains_key(index)) {
        files.drop_row(*index)?;
    }
    Ok(resumed)
}

/// Keys of the runs with these indices, computed by `jobs` threads.
fn keys_of(sweep: &Sweep, keys: &KeyMaker, indices: &[u64], jobs: usize) -> BTreeMap<u64, EditKey> {
    let (next, found) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    let worker = || {
        let mut own = Vec::new();
        while let Some(&index) = indices.get(next.fetch_add(1, Ordering::Relaxed)) {
            own.push((index, Resolved::new(sweep, index, keys).key));
        }
        found.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).extend(own);
    };
    std::thread::scope(|scope| {
        // The calling thread is one of the workers, and the only one if the system gives no other.
        (1..jobs).for_each(|_| _ = std::thread::Builder::new().spawn_scoped(scope, worker));
        worker();
    });
    found.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Writes a row again with the current index of its run.
fn move_row(sweep: &Sweep, index: u64, row: &RowRecord, files: &mut ShardFiles) -> Result<(), BatchError> {
    let Some(bytes) = files.row(row)? else { return Ok(()) };
    let old: Map<String, Value> = serde_json::from_slice(&bytes).unwrap_or_default();
    let mut cells = vec![Value::from(index), Value::from(row.key.to_string())];
    cells.extend(sweep.edit(index).cells);
    let given = cells.len();
    let rest = &sweep.columns()[given..];
    cells.extend(rest.iter().map(|column| old.get(&column.name).cloned().unwrap_or_default()));
    let text = row_json(sweep.columns(), &cells);
    let RowRecord { key, failed, attempts, seconds, .. } = row.clone();
    files.put(NewRow { edit: index, key, text: &text, failed, attempts, seconds })
}
