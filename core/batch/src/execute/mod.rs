//! Execution of the runs of a shard.

mod admission;
mod child;
mod failure;
mod measure;
mod options;
mod pool;
mod resume;
mod run_edit;
mod serve;
mod shard_run;

pub(crate) use admission::max_concurrent;
pub use child::Isolation;
pub use failure::{Failure, FailureClass};
pub(crate) use measure::SUMMARY;
pub use options::{BatchSummary, Progress, RunOptions};
pub use run_edit::{EditResult, EditSeconds};
pub(crate) use run_edit::{EditRunner, MODELS_KEPT, OpenedEdit};
pub use serve::{limit_memory, serve};
pub use shard_run::run;
