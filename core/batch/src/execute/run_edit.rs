//! Execution of one run, from its scene to the cells of its row, on one thread.

use super::failure::{Failure, FailureClass};
use super::measure::{TraceKeeper, summary_cells};
use super::options::RunOptions;
use crate::edit::Resolved;
use crate::error::BatchError;
use crate::store::MeshStore;
use crate::sweep::Sweep;
use pliant_engine::memory::MemoryBudget;
use pliant_engine::plan::Plan;
use pliant_engine::scene::Source;
use pliant_engine::session::{CancelToken, Options, Session, SharedParts};
use pliant_host::SearchPath;
use pliant_record::RunStatistics;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

/// The result of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EditResult {
    /// The failure, if the run failed.
    pub failure: Option<Failure>,
    /// Cells of the summary, the probes, the trace and the mesh; empty if the run did not get that far.
    pub cells: Vec<Value>,
    /// Times of its phases.
    pub seconds: EditSeconds,
}

impl EditResult {
    /// The result of a failed run, with empty cells.
    pub(crate) fn failed(failure: Failure, sweep: &Sweep, seconds: EditSeconds) -> Self {
        Self { failure: Some(failure), cells: vec![Value::Null; sweep.result_columns().len()], seconds }
    }
}

/// Wall-clock times of the phases of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EditSeconds {
    /// Time of reading the scene and opening the session, s.
    pub open: f64,
    /// Time of all steps, s.
    pub steps: f64,
    /// Total time, s.
    pub all: f64,
}

/// A run whose session is open.
pub(crate) struct OpenedEdit<'r> {
    /// Session at its start.
    pub(crate) session: Session,
    /// Number of steps of the scene.
    pub(crate) steps: u64,
    /// The scene's source.
    source: &'r Source,
}

/// Executes runs in this process.
pub(crate) struct EditRunner<'a> {
    /// Sweep of the runs.
    sweep: &'a Sweep,
    /// Folders in which plugins are searched.
    search: &'a SearchPath,
    /// Meshes that are kept.
    meshes: &'a MeshStore,
    /// Models and grids that several runs use.
    parts: &'a SharedParts,
    /// Memory that a run may take if the sweep has no limit for it.
    memory: MemoryBudget,
    /// Gets the estimated memory of each run once it is open, bytes.
    on_open: &'a dyn Fn(u64),
    /// Interrupts the current step.
    cancel: CancelToken,
}

/// Number of models that are kept for the next runs. Parallel runs have few different models, as neighbours in a sweep mostly have the same.
pub(crate) const MODELS_KEPT: usize = 8;

impl<'a> EditRunner<'a> {
    /// A runner for a sweep, with the search path, the memory and the stop of `options`. `on_open` gets the estimated memory of
    /// each run once it is open, bytes.
    pub(crate) fn new(
        sweep: &'a Sweep,
        options: &'a RunOptions,
        meshes: &'a MeshStore,
        parts: &'a SharedParts,
        on_open: &'a dyn Fn(u64),
    ) -> Self {
        let cancel = CancelToken::from(Arc::clone(&options.stop));
        Self { sweep, search: &options.search, meshes, parts, memory: options.memory, on_open, cancel }
    }

    /// Executes a run; `None` if `stop` returned true before its end. A panic is a failure of the run.
    ///
    /// # Errors
    /// Fails for a mesh that cannot be written.
    pub(crate) fn run(
        &self,
        resolved: &Resolved,
        began: Instant,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<EditResult>, BatchError> {
        catch_unwind(AssertUnwindSafe(|| self.run_inner(resolved, began, stop))).unwrap_or_else(|panic| {
            let failure = Failure::of_panic(panic.as_ref());
            let seconds = EditSeconds { all: began.elapsed().as_secs_f64(), ..EditSeconds::default() };
            Ok(Some(EditResult::failed(failure, self.sweep, seconds)))
        })
    }

    /// As [`EditRunner::run`]; may panic.
    fn run_inner(
        &self,
        resolved: &Resolved,
        began: Instant,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<EditResult>, BatchError> {
        let mut seconds = EditSeconds::default();
        let opened = self.open(resolved);
        seconds.open = began.elapsed().as_secs_f64();
        let OpenedEdit { mut session, steps, source } = match opened {
            Ok(opened) => opened,
            Err(failure) => {
                seconds.all = seconds.open;
                return Ok(Some(EditResult::failed(failure, self.sweep, seconds)));
            }
        };
        (self.on_open)(session.memory_estimate());
        let keep = &self.sweep.keep;
        let (mut run, mut trace) = (RunStatistics::new(source, &session, began), TraceKeeper::new(keep, &session));
        let mut failure = None;
        session.cancel_when(self.cancel.clone());
        while session.steps() < steps {
            session.step();
            if session.is_cancelled() {
                return Ok(None);
            }
            let last = session.steps() == steps;
            seconds.steps += session.frame().seconds;
            run.step(&mut session, last, false);
            trace.step(&session, last);
            if stop() {
                return Ok(None);
            }
            if let Some(limit) = self.sweep.limits.seconds.filter(|limit| began.elapsed().as_secs_f64() > *limit) {
                failure = Some(Failure::time_limit(limit));
                break;
            }
        }
        if let Some(failure) = failure {
            seconds.all = began.elapsed().as_secs_f64();
            return Ok(Some(EditResult::failed(failure, self.sweep, seconds)));
        }
        let mut cells = summary_cells(keep, &session, &run);
        if keep.probes {
            cells.extend(self.probe_cells(&run));
        }
        cells.extend(trace.cells());
        if keep.meshes {
            cells.push(self.keep_meshes(&mut session)?);
        }
        seconds.all = began.elapsed().as_secs_f64();
        Ok(Some(EditResult { failure: Failure::of_session(&session), cells, seconds }))
    }

    /// Opens the session of a run.
    pub(crate) fn open<'r>(&self, resolved: &'r Resolved) -> Result<OpenedEdit<'r>, Failure> {
        let (scene, source) = resolved.scene.as_ref().map_err(|e| Failure::new(FailureClass::Scene, e))?;
        let plan = Plan::new(scene, source).map_err(|e| Failure::new(FailureClass::Scene, e))?;
        let (search, mesh) = (self.search.clone(), resolved.edit.model.clone());
        let memory = self.sweep.limits.memory.map_or(self.memory, MemoryBudget::new);
        let options = Options { mesh, memory, ..Options::new(search, 1) };
        let session =
            Session::open_shared(scene, source, plan, &options, self.parts).map_err(|e| Failure::of_opening(&e))?;
        Ok(OpenedEdit { session, steps: scene.time.steps(), source })
    }

    /// A cell for each probe column; empty if this scene has no such probe.
    fn probe_cells(&self, run: &RunStatistics) -> Vec<Value> {
        let (columns, results) = (self.sweep.result_columns(), run.probes());
        let after = self.sweep.keep.summary.len();
        let count = columns.len() - after - self.sweep.keep.trace.len() - usize::from(self.sweep.keep.meshes);
        let cell = |column: &crate::Column| {
            let result = results.iter().find(|result| result.name == column.name);
            result.map_or(Value::Null, |result| crate::column::float_cell(result.value))
        };
        columns[after..after + count].iter().map(cell).collect()
    }

    /// Stores the meshes of all simulated bodies. The cell is the address of the mesh, or with several bodies an object of addresses by name.
    fn keep_meshes(&self, session: &mut Session) -> Result<Value, BatchError> {
        session.update_surface();
        let cap = session.plan().cap_material.clone();
        let mut addresses = Vec::new();
        for body in &session.bodies {
            addresses.push((body.name.clone(), Value::from(self.meshes.put(body, &cap)?)));
        }
        Ok(match addresses.len() {
            1 => addresses.remove(0).1,
            _ => Value::Object(addresses.into_iter().collect()),
        })
    }
}
