//! Records of a journal.

use crate::column::Column;
use crate::execute::{EditSeconds, FailureClass};
use crate::key::EditKey;
use crate::shard::Shard;
use serde::{Deserialize, Serialize};

/// A record of a journal.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "record", rename_all = "kebab-case")]
pub(crate) enum Record {
    /// A process opened the shard.
    Open(OpenRecord),
    /// A run began.
    Begin {
        /// Index of the run.
        edit: u64,
        /// Number of the attempt, from 1.
        attempt: u32,
    },
    /// The row of a run was written to the table. It replaces an older one.
    Row(RowRecord),
    /// The row of a run is invalid: its scene, a file of it or the program has changed.
    Drop {
        /// Index of the run.
        edit: u64,
    },
    /// The process has closed the shard.
    Close(CloseRecord),
}

/// A process opened the shard.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct OpenRecord {
    /// Version of the journal's format.
    pub(crate) format: u32,
    /// Program and version of the results.
    pub(crate) program: String,
    /// Digest of the sweep.
    pub(crate) sweep: String,
    /// Title of the sweep.
    pub(crate) title: String,
    /// Number of the shard, from 1.
    pub(crate) shard: u64,
    /// Number of shards.
    pub(crate) shards: u64,
    /// Number of runs of the whole sweep.
    pub(crate) edits: u64,
    /// Columns of the table.
    pub(crate) columns: Vec<Column>,
    /// The process, by its number and host.
    pub(crate) process: String,
    /// Time, s since 1970.
    pub(crate) time: f64,
}

impl OpenRecord {
    /// The shard that the process runs, and the number of shards.
    pub(crate) fn shard(&self) -> Shard {
        Shard { number: self.shard, count: self.shards }
    }
}

/// The row of a run in the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RowRecord {
    /// Index of the run.
    pub(crate) edit: u64,
    /// Key of the run.
    pub(crate) key: EditKey,
    /// Start of the row in the table, bytes.
    pub(crate) at: u64,
    /// Length of the row with its line break, bytes.
    pub(crate) length: u64,
    /// CRC-32 of the row.
    pub(crate) crc: u32,
    /// Class of the failure, if the run failed.
    pub(crate) failed: Option<FailureClass>,
    /// Number of attempts.
    pub(crate) attempts: u32,
    /// Times of its phases.
    pub(crate) seconds: EditSeconds,
}

/// The process has closed the shard.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct CloseRecord {
    /// Whether the batch was stopped before the last run.
    pub(crate) stopped: bool,
    /// Time, s since 1970.
    pub(crate) time: f64,
}
