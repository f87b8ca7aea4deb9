//! One edit, from its scene to the cells of its row, on one thread.

use super::failure::{Failure, FailureClass};
use super::measure::{TraceKeeper, summary_cells};
use crate::edit::Resolved;
use crate::error::BatchError;
use crate::store::MeshStore;
use crate::sweep::Sweep;
use pliant_engine::plan::Plan;
use pliant_engine::scene::Source;
use pliant_engine::session::{CancelToken, Options, Session, SharedParts};
use pliant_host::SearchPath;
use pliant_record::RunStatistics;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// What an edit came to.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EditResult {
    /// Why it failed, if it did.
    pub failure: Option<Failure>,
    /// Cells of the summary, the probes, the trace and the mesh; empty cells where it did not come so far.
    pub cells: Vec<Value>,
    /// Where its time went.
    pub seconds: EditSeconds,
}

impl EditResult {
    /// An edit that came to nothing.
    pub(crate) fn failed(failure: Failure, sweep: &Sweep, seconds: EditSeconds) -> Self {
        Self { failure: Some(failure), cells: vec![Value::Null; sweep.result_columns().len()], seconds }
    }
}

/// Where the wall-clock time of an edit went, s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EditSeconds {
    /// s, from its place in the sweep to an open session
    pub open: f64,
    /// s, inside of steps
    pub steps: f64,
    /// s, altogether
    pub all: f64,
}

/// An edit whose session is open.
pub(crate) struct OpenedEdit<'r> {
    pub(crate) session: Session,
    /// Number of steps it takes.
    pub(crate) steps: u64,
    source: &'r Source,
}

/// What edits of one process share.
pub(crate) struct EditRunner<'a> {
    pub(crate) sweep: &'a Sweep,
    pub(crate) search: &'a SearchPath,
    pub(crate) meshes: &'a MeshStore,
    pub(crate) parts: &'a SharedParts,
    /// Ends the step under way.
    pub(crate) cancel: CancelToken,
}

/// Models whose parts are kept for the next edits: those of edits at a time are of few models, as places next to each other in a sweep have
/// the same one.
pub(crate) const MODELS_KEPT: usize = 8;

impl EditRunner<'_> {
    /// Runs an edit; `None` if `stop` said so before its end. A panic is a failure of the edit.
    ///
    /// # Errors
    /// A mesh that cannot be written.
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

    /// Opens the session of an edit.
    pub(crate) fn open<'r>(&self, resolved: &'r Resolved) -> Result<OpenedEdit<'r>, Failure> {
        let (scene, source) = resolved.scene.as_ref().map_err(|e| Failure::new(FailureClass::Scene, e))?;
        let plan = Plan::new(scene, source).map_err(|e| Failure::new(FailureClass::Scene, e))?;
        let (search, mesh) = (self.search.clone(), resolved.edit.model.clone());
        let options = Options { search, threads: 1, mesh, recorded: None };
        let session =
            Session::open_shared(scene, source, plan, &options, self.parts).map_err(|e| Failure::of_opening(&e))?;
        Ok(OpenedEdit { session, steps: scene.time.steps(), source })
    }

    /// A cell for each column of a probe; an empty one where this scene has no such probe.
    fn probe_cells(&self, run: &RunStatistics) -> Vec<Value> {
        let (columns, results) = (self.sweep.result_columns(), run.probes());
        let after = self.sweep.keep.summary.len();
        let count = columns.len() - after - self.sweep.keep.trace.len() - usize::from(self.sweep.keep.meshes);
        let cell = |column: &crate::Column| {
            let result = results.iter().find(|result| result.name == column.name);
            result.map_or(Value::Null, |result| crate::column::number(result.value))
        };
        columns[after..after + count].iter().map(cell).collect()
    }

    /// Keeps the meshes of all moving bodies: the cell is the address of the only one, or an object of addresses by body.
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
