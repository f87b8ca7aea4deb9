//! Estimates of the time and memory of a sweep, from a few of its runs, which are opened and not executed.

use crate::column::ColumnType;
use crate::edit::Resolved;
use crate::error::BatchError;
use crate::execute::{EditRunner, MODELS_KEPT, OpenedEdit, RunOptions, max_concurrent};
use crate::key::KeyMaker;
use crate::store::MeshStore;
use crate::sweep::Sweep;
use pliant_engine::session::SharedParts;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// Number of runs that are opened, evenly spaced over the shard.
const SAMPLES: u64 = 8;
/// Mean size of a number in a row without its name, bytes: at most 17 digits, sign, exponent and comma.
const NUMBER_BYTES: u64 = 18;

/// Estimated time and size of a shard.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// Number of runs of the whole sweep.
    pub edits: u64,
    /// Number of runs of the shard.
    pub shard_edits: u64,
    /// Number of runs that were opened for this estimate.
    pub opened: u64,
    /// Messages of runs that cannot be opened.
    pub failures: Vec<String>,
    /// Mean time of all steps of a run under a tool, s.
    pub step_seconds: f64,
    /// Mean time of opening a run, s.
    pub open_seconds: f64,
    /// Time of the whole shard with `jobs` parallel runs, s.
    pub seconds: f64,
    /// Number of parallel runs.
    pub jobs: usize,
    /// Size of the table and the journal, bytes.
    pub table_bytes: u64,
    /// Size of the meshes if they are kept and all differ, bytes.
    pub mesh_bytes: u64,
    /// Largest estimate of the memory of a run, bytes.
    pub edit_memory: u64,
}

/// Estimates the time and size of a shard.
///
/// # Errors
/// Fails if none of the sampled runs can be opened.
pub fn estimate(sweep: &Sweep, options: &RunOptions) -> Result<Estimate, BatchError> {
    let keys = KeyMaker::new(&options.program, &options.search);
    let meshes = MeshStore::new(Path::new("."));
    let parts = SharedParts::new(MODELS_KEPT);
    let runner = EditRunner::new(sweep, options, &meshes, &parts, &|_| {});
    let edits: Vec<u64> = options.shard.edits(sweep.edits()).collect();
    let samples = SAMPLES.min(edits.len() as u64);
    let mut all = Estimate {
        edits: sweep.edits(),
        shard_edits: edits.len() as u64,
        opened: 0,
        failures: Vec::new(),
        step_seconds: 0.0,
        open_seconds: 0.0,
        seconds: 0.0,
        jobs: options.jobs(),
        table_bytes: 0,
        mesh_bytes: 0,
        edit_memory: 0,
    };
    let (mut row_bytes, mut mesh_bytes) = (0, 0);
    for i in 0..samples {
        let index = edits[(i * edits.len() as u64 / samples) as usize];
        let began = Instant::now();
        let resolved = Resolved::new(sweep, index, &keys);
        match runner.open(&resolved) {
            Err(failure) => all.failures.push(format!("run {index}: {}: {}", failure.class, failure.message)),
            Ok(OpenedEdit { session, steps, .. }) => {
                all.opened += 1;
                all.open_seconds += began.elapsed().as_secs_f64();
                all.step_seconds += steps as f64 * session.step_costs().iter().map(|cost| cost.seconds).sum::<f64>();
                all.edit_memory = all.edit_memory.max(session.memory_estimate());
                row_bytes += bytes_of_row(sweep, steps);
                mesh_bytes += session.bodies.iter().map(|b| b.model.document.bytes().len() as u64).sum::<u64>();
            }
        }
    }
    if all.opened == 0 && samples > 0 {
        let why = all.failures.join("\n");
        return Err(BatchError::Input(format!("none of {samples} runs can be opened:\n{why}")));
    }
    let opened = all.opened.max(1);
    all.open_seconds /= opened as f64;
    all.step_seconds /= opened as f64;
    if !options.oversubscribe {
        all.jobs = all.jobs.min(max_concurrent(options.memory, sweep.limits.memory.unwrap_or(all.edit_memory)));
    }
    all.seconds = (all.open_seconds + all.step_seconds) * all.shard_edits as f64 / all.jobs as f64;
    all.table_bytes = row_bytes / opened * all.shard_edits;
    all.mesh_bytes = if sweep.keep.meshes { mesh_bytes / opened * all.shard_edits } else { 0 };
    Ok(all)
}

/// Size of a row and of its records in the journal, bytes.
fn bytes_of_row(sweep: &Sweep, steps: u64) -> u64 {
    /// Bytes of the records of one run in the journal.
    const RECORDS: u64 = 330;
    let kept = steps.div_ceil(sweep.keep.trace_every);
    let cell = |column_type: ColumnType| match column_type {
        ColumnType::FloatList => NUMBER_BYTES * kept,
        ColumnType::Integer | ColumnType::Float | ColumnType::Boolean | ColumnType::Text => NUMBER_BYTES,
    };
    RECORDS + sweep.columns().iter().map(|column| column.name.len() as u64 + 4 + cell(column.column_type)).sum::<u64>()
}
