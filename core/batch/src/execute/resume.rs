//! What of a shard is there already, and what is missing.

use super::options::RunOptions;
use crate::column::row_text;
use crate::edit::Resolved;
use crate::error::BatchError;
use crate::key::{EditKey, KeyMaker};
use crate::store::{NewRow, RowRecord, ShardFiles, ShardState};
use crate::sweep::Sweep;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, HashMap};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What is there and what is missing.
pub(super) struct Missing {
    /// Places of edits without a row, rising, and the attempts that a killed process made.
    pub(super) edits: Vec<(u64, u32)>,
    /// Edits with a row.
    pub(super) done: u64,
    /// Failed ones of them.
    pub(super) failed: u64,
    /// Rows that no longer count.
    pub(super) outdated: u64,
}

/// Compares the rows of a shard with the sweep as it is now: rows whose edit is the same count, rows of an edit that now has another place
/// are written again with it, and others no longer count.
pub(super) fn missing(
    sweep: &Sweep,
    keys: &KeyMaker,
    options: &RunOptions,
    files: &mut ShardFiles,
    state: ShardState,
) -> Result<Missing, BatchError> {
    let places: Vec<u64> = options.shard.edits(sweep.edits()).collect();
    let mut missing = Missing { edits: Vec::new(), done: 0, failed: 0, outdated: 0 };
    let again = |row: &RowRecord| options.retry_failed && row.failed.is_some();
    let same_columns = state.opened.as_ref().is_none_or(|open| open.columns == sweep.columns());
    let known: HashMap<EditKey, RowRecord> = match same_columns {
        true => state.rows.values().filter(|row| !again(row)).map(|row| (row.key.clone(), row.clone())).collect(),
        false => HashMap::new(),
    };
    let mut current = if known.is_empty() { BTreeMap::new() } else { keys_of(sweep, keys, &places, options.jobs()) };
    let mut kept: BTreeMap<u64, RowRecord> = BTreeMap::new();
    for &place in &places {
        let row = current.remove(&place).and_then(|key| known.get(&key));
        match row {
            None => missing.edits.push((place, state.under_way.get(&place).copied().unwrap_or(0))),
            Some(row) => {
                missing.failed += u64::from(row.failed.is_some());
                kept.insert(place, row.clone());
            }
        }
    }
    missing.done = kept.len() as u64;
    let still: std::collections::HashSet<&EditKey> = kept.values().map(|row| &row.key).collect();
    missing.outdated = state.rows.values().filter(|row| !again(row) && !still.contains(&row.key)).count() as u64;
    for (place, row) in &kept {
        if row.edit != *place {
            move_row(sweep, *place, row, files)?;
        }
    }
    for place in state.rows.keys().filter(|place| !kept.contains_key(place)) {
        files.drop_row(*place)?;
    }
    Ok(missing)
}

/// Keys of edits, found on all processors.
fn keys_of(sweep: &Sweep, keys: &KeyMaker, places: &[u64], jobs: usize) -> BTreeMap<u64, EditKey> {
    let (next, found) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                let mut own = Vec::new();
                while let Some(&place) = places.get(next.fetch_add(1, Ordering::Relaxed)) {
                    own.push((place, Resolved::new(sweep, place, keys).key));
                }
                found.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).extend(own);
            });
        }
    });
    found.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Writes a row again under the place its edit has now.
fn move_row(sweep: &Sweep, place: u64, row: &RowRecord, files: &mut ShardFiles) -> Result<(), BatchError> {
    let Some(bytes) = files.row(row)? else { return Ok(()) };
    let old: Map<String, Value> = serde_json::from_slice(&bytes).unwrap_or_default();
    let mut cells = vec![Value::from(place), Value::from(row.key.to_string())];
    cells.extend(sweep.edit(place).cells);
    let given = cells.len();
    let rest = &sweep.columns()[given..];
    cells.extend(rest.iter().map(|column| old.get(&column.name).cloned().unwrap_or_default()));
    let text = row_text(sweep.columns(), &cells);
    let RowRecord { key, failed, attempts, seconds, .. } = row.clone();
    files.put(NewRow { edit: place, key, text: &text, failed, attempts, seconds })
}
