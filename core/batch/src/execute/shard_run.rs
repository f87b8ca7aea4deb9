//! Execution of one shard of a sweep.

use super::options::{BatchSummary, Progress, RunOptions};
use super::pool::Pool;
use super::resume::compare_with_sweep;
use crate::error::BatchError;
use crate::key::KeyMaker;
use crate::store::{MeshStore, ShardFiles};
use crate::sweep::Sweep;
use std::path::Path;
use std::sync::Arc;

/// Executes the runs of a shard that have no row yet, and appends a row for each to the shard's files in `folder`. `progress` is called several
/// times a second.
///
/// The row of a failed run has the reason. A batch that is stopped, is killed or fails keeps its rows; a batch with [`RunOptions::resume`] completes
/// it.
///
/// # Errors
/// A shard that another process runs or that has rows without `resume`, files that cannot be written, isolation without a way to start a
/// child.
pub fn run(
    sweep: Sweep,
    folder: &Path,
    options: RunOptions,
    progress: &mut dyn FnMut(Progress),
) -> Result<BatchSummary, BatchError> {
    if (options.isolate || sweep.limits.memory.is_some()) && options.isolation.is_none() {
        let text = "runs with a limit of memory need child processes, and the caller starts none";
        return Err(BatchError::Input(text.into()));
    }
    let (mut files, state) = ShardFiles::open(folder, options.shard, options.resume)?;
    let meshes = MeshStore::new(folder);
    if sweep.keep.meshes && state.opened.is_some() {
        meshes.remove_leftovers();
    }
    let keys = KeyMaker::new(&options.program, &options.search);
    let resumed = compare_with_sweep(&sweep, &keys, &options, &mut files, state)?;
    files.begin(&sweep, options.shard, &options.program)?;
    Pool::new(Arc::new(sweep), keys, meshes, options, files, resumed)?.run(progress)
}
