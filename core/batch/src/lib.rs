//! Many scripted edits: one description, any number of processes, one table.
//!
//! A [`Sweep`] is read from a file: base scenes, models, and axes whose product is the list of edits. [`run`] does the edits of one shard
//! in parallel and appends a row for each to the shard's files; an edit that is there already is not done again. [`collect()`] merges
//! shards to one table, [`status`] tells how far they are, [`plot()`] draws them, [`launcher`] writes a script for a cluster.
//!
//! A [`SessionBatch`] is the other way to use many sessions: all are open, and a caller steps them together and moves their hands.
//!
//! An edit is known by a digest of its resolved scene, the bytes of its meshes and plugins, and the program's version ([`EditKey`]). Rows
//! hold nothing that depends on time or machine, so any way of running a sweep gives the same table.
//!
//! This crate prints nothing and starts no process but those its caller describes.
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
//! println!("{} edits, {} failed", end.done, end.failed);
//! # Ok(())
//! # }
//! ```

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

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
pub use column::{Column, ColumnKind};
pub use edit::{Edit, Resolved};
pub use error::BatchError;
pub use estimate::{Estimate, estimate};
pub use execute::{
    BatchEnd, EditResult, EditSeconds, Failure, FailureClass, Isolation, Progress, RunOptions, limit_memory, run, serve,
};
pub use key::EditKey;
pub use plot::{PlotOptions, plot};
pub use script::{Engine, Launch, launcher};
pub use session_batch::{InstanceRun, SceneInstance, SessionBatch, ToolSeries};
pub use shard::Shard;
pub use status::{ShardStatus, status};
pub use sweep::{Keep, Limits, Sweep};
