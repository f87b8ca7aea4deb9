//! Parameter sweeps over scripted scenes, executed by any number of processes, with one table of results. A point of a sweep is a run; columns,
//! JSON keys and identifiers call it `edit`.
//!
//! A [`Sweep`] is read from a file: base scenes, models, and axes whose product is the list of runs. [`run`] executes the runs of one shard in
//! parallel and appends a row for each to the shard's files; runs that have a row are not repeated. [`collect()`] merges shards into one table,
//! [`status`] reports their progress, [`plot()`] draws columns, and [`launcher`] writes a script for a cluster.
//!
//! With a [`SessionBatch`] many sessions are open at once: the caller steps them together and moves their hands.
//!
//! A run is identified by a digest of its resolved scene, the bytes of its meshes and plugins, and the program's version ([`EditKey`]). Rows do
//! not depend on time or machine, so all ways of running a sweep give the same table.
//!
//! This crate prints nothing, and starts no processes but those that its caller describes.
//!
//! # Example
//! ```no_run
//! use pliant_batch::{RunOptions, Shard, Sweep, run};
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let sweep = Sweep::read(Path::new("sweep.toml"))?;
//! let options = RunOptions { shard: Shard::default(), jobs: 2, ..RunOptions::new(pliant_host::SearchPath::new(&[])) };
//! let end = run(sweep, Path::new("out/sweep"), options, &mut |progress| println!("{} done", progress.done))?;
//! println!("{} runs, {} failed", end.done, end.failed);
//! # Ok(())
//! # }
//! ```

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]
#![deny(clippy::wildcard_enum_match_arm)]

mod collect;
mod column;
mod edit;
mod error;
mod estimate;
mod execute;
mod key;
mod plot;
mod script;
mod session_batch;
mod shard;
mod status;
mod store;
mod sweep;

pub use collect::{CollectOptions, Collected, Format, Table, collect};
pub use column::{Column, ColumnType};
pub use edit::{Edit, Resolved};
pub use error::BatchError;
pub use estimate::{Estimate, estimate};
pub use execute::{
    BatchSummary, EditResult, EditSeconds, Failure, FailureClass, Isolation, Progress, RunOptions, limit_memory, run,
    serve,
};
pub use key::EditKey;
pub use plot::{PlotOptions, plot};
pub use script::{Engine, Launch, launcher};
pub use session_batch::{InstanceRun, SceneInstance, SessionBatch, ToolSeries};
pub use shard::Shard;
pub use status::{ShardStatus, status};
pub use sweep::{Keep, Limits, Sweep};

/// The parser of journals, for tests and fuzzing.
#[cfg(feature = "testing")]
pub mod testing {
    /// Number of whole records at the beginning of a journal, and their length in bytes.
    pub fn parse_journal(bytes: &[u8]) -> (usize, usize) {
        let journal = crate::store::journal::parse_journal(bytes);
        (journal.records.len(), journal.length as usize)
    }
}
