//! The state of a shard, from its files.

use super::journal::{ParsedJournal, parse_journal};
use super::records::{CloseRecord, OpenRecord, Record, RowRecord};
use crate::error::BatchError;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// The version of the journal's format.
pub(super) const FORMAT: u32 = 1;

/// The state of a shard, from its journal.
#[derive(Debug, Default)]
pub(crate) struct ShardState {
    /// Record of the last process that opened it; `None` for an empty journal.
    pub(crate) opened: Option<OpenRecord>,
    /// Valid rows by the index of their run.
    pub(crate) rows: BTreeMap<u64, RowRecord>,
    /// Runs that began and have no row since, with their numbers of attempts.
    pub(crate) under_way: BTreeMap<u64, u32>,
    /// Record of the end of the last process; `None` while it runs, or if it was killed.
    pub(crate) closed: Option<CloseRecord>,
    /// Length of the valid part of the journal, bytes.
    pub(super) journal_length: u64,
}

impl ShardState {
    /// The state from the bytes of a journal.
    fn parse(bytes: &[u8], path: &Path) -> Result<Self, BatchError> {
        let ParsedJournal { records, length } = parse_journal(bytes);
        let mut state = Self { journal_length: length, ..Self::default() };
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
        // A file with lines but without a record is not a journal, and must not be overwritten.
        if length == 0 && bytes.contains(&b'\n') {
            let reason = "is no journal of a batch; allowed is a folder that only batches write to".into();
            return Err(BatchError::Journal { path: path.to_path_buf(), reason });
        }
        Ok(state)
    }

    /// Length of the part of the table with rows, bytes.
    pub(super) fn table_length(&self) -> u64 {
        self.rows.values().map(|row| row.at + row.length).max().unwrap_or(0)
    }
}

/// Reads the state of a shard from its journal.
pub(crate) fn read_state(journal: &mut File, path: &Path) -> Result<ShardState, BatchError> {
    let mut bytes = Vec::new();
    journal.seek(SeekFrom::Start(0)).and_then(|_| journal.read_to_end(&mut bytes)).map_err(BatchError::at(path))?;
    ShardState::parse(&bytes, path)
}

/// The bytes of a row; `None` if they do not match their checksum or are missing.
pub(crate) fn row_bytes(table: &mut File, row: &RowRecord) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = vec![0; row.length as usize];
    table.seek(SeekFrom::Start(row.at))?;
    match table.read_exact(&mut bytes) {
        Ok(()) => Ok((crc32fast::hash(&bytes) == row.crc).then_some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
        Err(error) => Err(error),
    }
}
