//! Records of a journal.

use crate::column::Column;
use crate::execute::{EditSeconds, FailureClass};
use crate::key::EditKey;
use crate::shard::Shard;
use serde::{Deserialize, Serialize};

/// One record of a journal.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "record", rename_all = "kebab-case")]
pub(crate) enum Record {
    /// A process opened the shard.
    Open(OpenRecord),
    /// An edit began.
    Begin {
        /// Its place in the sweep.
        edit: u64,
        /// Number of the attempt, from 1.
        attempt: u32,
    },
    /// The row of an edit stands in the table. It takes the place of an older one.
    Row(RowRecord),
    /// The row of an edit no longer counts: its scene, a file of it, or the program has changed.
    Drop {
        /// Its place in the sweep.
        edit: u64,
    },
    /// The process is done with the shard.
    Close(CloseRecord),
}

/// A process opened the shard.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct OpenRecord {
    /// Version of the journal's format.
    pub(crate) format: u32,
    /// Program and version whose results these are.
    pub(crate) program: String,
    /// Digest of the sweep.
    pub(crate) sweep: String,
    /// Title of the sweep.
    pub(crate) title: String,
    /// Number of the shard, from 1.
    pub(crate) shard: u64,
    /// Number of shards.
    pub(crate) shards: u64,
    /// Number of edits of the whole sweep.
    pub(crate) edits: u64,
    /// Columns of the table.
    pub(crate) columns: Vec<Column>,
    /// The process, by its number and host.
    pub(crate) process: String,
    /// s, since 1970
    pub(crate) time: f64,
}

impl OpenRecord {
    /// The shard.
    pub(crate) fn shard(&self) -> Shard {
        Shard { number: self.shard, count: self.shards }
    }
}

/// The row of an edit stands in the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RowRecord {
    /// Its place in the sweep.
    pub(crate) edit: u64,
    /// What it is known by.
    pub(crate) key: EditKey,
    /// Bytes, where the row begins in the table.
    pub(crate) at: u64,
    /// Bytes, its length with the line break.
    pub(crate) length: u64,
    /// CRC-32 of these bytes.
    pub(crate) crc: u32,
    /// Why it failed, if it did.
    pub(crate) failed: Option<FailureClass>,
    /// Number of attempts it took.
    pub(crate) attempts: u32,
    /// Where its time went.
    pub(crate) seconds: EditSeconds,
}

/// The process is done with the shard.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct CloseRecord {
    /// Whether it was stopped before the last edit.
    pub(crate) stopped: bool,
    /// s, since 1970
    pub(crate) time: f64,
}
