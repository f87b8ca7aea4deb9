//! What a shard's files come to.

use super::journal::records;
use super::records::{CloseRecord, OpenRecord, Record, RowRecord};
use crate::error::BatchError;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// The version of the journal's format.
pub(super) const FORMAT: u32 = 1;

/// A shard, as its journal tells it.
#[derive(Debug, Default)]
pub(crate) struct ShardState {
    /// The last process that opened it; `None` of a journal without a whole record.
    pub(crate) opened: Option<OpenRecord>,
    /// Rows that count, by their place in the sweep.
    pub(crate) rows: BTreeMap<u64, RowRecord>,
    /// Edits that began and have no row since, with the number of attempts.
    pub(crate) under_way: BTreeMap<u64, u32>,
    /// How the last process ended; `None` while it runs, or if it was killed.
    pub(crate) closed: Option<CloseRecord>,
    /// Bytes of whole records.
    pub(super) valid: u64,
}

impl ShardState {
    /// The state that these bytes of a journal tell.
    fn of(bytes: &[u8], path: &Path) -> Result<Self, BatchError> {
        let (records, valid) = records(bytes);
        let mut state = Self { valid, ..Self::default() };
        for record in records {
            match record {
                Record::Open(open) if open.format == FORMAT => (state.opened, state.closed) = (Some(open), None),
                Record::Open(open) => {
                    let reason = format!("format {}; allowed is {FORMAT}, the one this program reads", open.format);
                    return Err(BatchError::Journal { path: path.to_path_buf(), reason });
                }
                Record::Begin { edit, attempt } => _ = state.under_way.insert(edit, attempt),
                Record::Row(row) => {
                    state.under_way.remove(&row.edit);
                    state.rows.insert(row.edit, row);
                }
                Record::Drop { edit } => _ = state.rows.remove(&edit),
                Record::Close(close) => state.closed = Some(close),
            }
        }
        // A file of many bytes without one record is something else, and is not written over.
        if valid == 0 && bytes.contains(&b'\n') {
            let reason = "is no journal of a batch; allowed is a folder that only batches write to".into();
            return Err(BatchError::Journal { path: path.to_path_buf(), reason });
        }
        Ok(state)
    }

    /// Bytes of the table that rows were written to.
    pub(super) fn table_length(&self) -> u64 {
        self.rows.values().map(|row| row.at + row.length).max().unwrap_or(0)
    }
}

/// Reads the state of a shard from its journal, from the beginning of the file.
pub(crate) fn read_state(journal: &mut File, path: &Path) -> Result<ShardState, BatchError> {
    let mut bytes = Vec::new();
    journal.seek(SeekFrom::Start(0)).and_then(|_| journal.read_to_end(&mut bytes)).map_err(BatchError::at(path))?;
    ShardState::of(&bytes, path)
}

/// The bytes of a row, if they are those that were written.
pub(crate) fn row_bytes(table: &mut File, row: &RowRecord) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = vec![0; row.length as usize];
    table.seek(SeekFrom::Start(row.at))?;
    match table.read_exact(&mut bytes) {
        Ok(()) => Ok((crc32fast::hash(&bytes) == row.crc).then_some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
        Err(error) => Err(error),
    }
}
