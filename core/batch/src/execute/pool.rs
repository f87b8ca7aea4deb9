//! Worker threads that execute the runs of a queue, and their supervision.
//!
//! A worker records the start of its run and writes the row itself, under the lock of the queue. The calling thread flushes the files, reports
//! the progress, and abandons workers in a plugin call that does not return: such a thread cannot be ended, so its run counts as failed and a
//! new thread replaces it.

use super::admission::Admission;
use super::child::ChildRunner;
use super::failure::Failure;
use super::options::{BatchSummary, Progress, RunOptions};
use super::resume::{MissingEdit, ResumeState};
use super::run_edit::{EditResult, EditRunner, EditSeconds, MODELS_KEPT};
use crate::column::row_json;
use crate::edit::Resolved;
use crate::error::BatchError;
use crate::key::{EditKey, KeyMaker};
use crate::store::{MeshStore, NewRow, ShardFiles, Syncer};
use crate::sweep::Sweep;
use pliant_engine::session::SharedParts;
use serde_json::Value;
use std::collections::{HashMap, VecDeque};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Interval of supervision, and largest delay until a row is flushed. With a shorter one a network file system would have more flushes than
/// rows.
const TICK: Duration = Duration::from_millis(250);
/// Time after its limit at which the thread of a run is abandoned: the limit is checked between steps alone.
const GRACE: Duration = Duration::from_secs(2);
/// Time for active runs to end after the batch is stopped.
const STOP_GRACE: Duration = Duration::from_secs(5);

/// A run that waits.
#[derive(Clone, Copy)]
struct Task {
    /// Index of the run.
    edit: u64,
    /// Attempts before this one.
    attempts: u32,
    /// Whether it runs in a child process.
    isolated: bool,
}

/// An active run.
struct Running {
    /// The run and its number of attempts.
    task: Task,
    /// Its key, once it is known.
    key: Option<EditKey>,
    /// Time at which it began.
    began: Instant,
}

/// Shared state of the workers, under one lock.
struct State {
    /// Runs that wait.
    queue: VecDeque<Task>,
    /// Holds runs back for which there is no memory.
    admission: Admission,
    /// Active runs by the number of their worker.
    running: HashMap<usize, Running>,
    /// Journal and table.
    files: ShardFiles,
    /// Progress of the shard.
    progress: Progress,
    /// Time of the steps of all runs so far, s.
    step_seconds: f64,
    /// Total time of all runs so far, s.
    edit_seconds: f64,
    /// The first error; it ends the batch.
    error: Option<BatchError>,
}

/// Shared data of the workers.
struct Shared {
    /// Sweep whose runs are executed.
    sweep: Arc<Sweep>,
    /// Computes the key of each run from its scene and files.
    keys: KeyMaker,
    /// Meshes that are kept.
    meshes: MeshStore,
    /// Models and grids that several runs use.
    parts: SharedParts,
    /// Options of the batch.
    options: RunOptions,
    /// State that changes.
    state: Mutex<State>,
    /// Notified when the queue or the active runs change.
    changed: Condvar,
}

impl Shared {
    /// Locks the state.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Whether the batch is stopped.
    fn stopped(&self) -> bool {
        self.options.stop.load(Ordering::Relaxed)
    }
}

/// The workers of a shard.
pub(super) struct Pool {
    /// Data of the workers.
    shared: Arc<Shared>,
    /// Flushes the files.
    syncer: Syncer,
    /// Time at which the batch began.
    began: Instant,
    /// Number of rows from before that are invalid.
    outdated: u64,
    /// Threads by the number of the worker.
    workers: HashMap<usize, JoinHandle<()>>,
    /// Number of the next worker.
    next: usize,
    /// Number of abandoned threads.
    abandoned: usize,
}

impl Pool {
    /// A pool for the missing runs of a shard, without workers.
    pub(super) fn new(
        sweep: Arc<Sweep>,
        keys: KeyMaker,
        meshes: MeshStore,
        options: RunOptions,
        files: ShardFiles,
        resumed: ResumeState,
    ) -> Result<Self, BatchError> {
        let isolated = options.isolate || sweep.limits.memory.is_some();
        // A run that was active when a process was killed may have caused it.
        let is_suspect = |attempts: u32| attempts > 0 && options.isolation.is_some();
        let task = |missing: MissingEdit| Task {
            edit: missing.index,
            attempts: 0,
            isolated: isolated || is_suspect(missing.attempts),
        };
        let progress = Progress {
            edits: options.shard.len(sweep.edits()),
            done: resumed.done,
            failed: resumed.failed,
            ..Progress::default()
        };
        let syncer = files.syncer()?;
        let budget = (!options.oversubscribe).then_some(options.memory);
        let state = State {
            admission: Admission::new(budget, sweep.limits.memory),
            queue: resumed.edits.into_iter().map(task).collect(),
            running: HashMap::new(),
            files,
            progress,
            step_seconds: 0.0,
            edit_seconds: 0.0,
            error: None,
        };
        let shared = Shared {
            sweep,
            keys,
            meshes,
            parts: SharedParts::new(MODELS_KEPT),
            options,
            state: Mutex::new(state),
            changed: Condvar::new(),
        };
        Ok(Self {
            shared: Arc::new(shared),
            syncer,
            began: Instant::now(),
            outdated: resumed.outdated,
            workers: HashMap::new(),
            next: 0,
            abandoned: 0,
        })
    }

    /// Executes all runs.
    pub(super) fn run(mut self, progress: &mut dyn FnMut(Progress)) -> Result<BatchSummary, BatchError> {
        let jobs = self.shared.options.jobs();
        let wanted = jobs.min(self.shared.lock().queue.len());
        for _ in 0..wanted {
            match self.start_worker() {
                // With fewer workers it takes longer.
                Err(_) if !self.workers.is_empty() => break,
                started => started?,
            }
        }
        let refused = wanted - self.workers.len();
        let mut stopping: Option<Instant> = None;
        loop {
            self.join_ended();
            if self.workers.is_empty() {
                break;
            }
            progress(self.progress());
            {
                let state = self.shared.lock();
                let waits = |state: &mut State| !state.queue.is_empty() || !state.running.is_empty();
                drop(self.shared.changed.wait_timeout_while(state, TICK, waits));
            }
            self.syncer.sync()?;
            self.abandon_hanging()?;
            let ending = self.shared.stopped() || self.shared.lock().error.is_some();
            if ending && stopping.get_or_insert_with(Instant::now).elapsed() > STOP_GRACE {
                self.abandoned += self.workers.len();
                self.shared.lock().running.clear();
                break;
            }
        }
        self.finish(if refused > 0 { wanted - refused } else { jobs }, refused, progress)
    }

    /// Closes the files and returns the result.
    fn finish(
        self,
        jobs: usize,
        refused: usize,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<BatchSummary, BatchError> {
        let last = self.progress();
        progress(last);
        let mut state = self.shared.lock();
        if let Some(error) = state.error.take() {
            return Err(error);
        }
        let stopped = last.done < last.edits;
        let (jobs_asked, allowed) = (self.shared.options.jobs_asked(), self.shared.options.jobs());
        state.files.close(stopped)?;
        self.syncer.sync()?;
        Ok(BatchSummary {
            edits: last.edits,
            done: last.done,
            failed: last.failed,
            new: last.new,
            outdated: self.outdated,
            stopped,
            abandoned: self.abandoned,
            elapsed: last.elapsed,
            step_seconds: state.step_seconds,
            edit_seconds: state.edit_seconds,
            jobs_asked,
            jobs_on_processors: Some(allowed).filter(|allowed| *allowed < jobs_asked),
            jobs,
            jobs_in_memory: state.admission.memory_limited_at(),
            edit_memory: state.admission.edit_memory(),
            refused,
        })
    }

    /// The progress now.
    fn progress(&self) -> Progress {
        Progress { elapsed: self.began.elapsed().as_secs_f64(), ..self.shared.lock().progress }
    }

    /// Starts a worker.
    fn start_worker(&mut self) -> Result<(), BatchError> {
        let (number, shared) = (self.next, Arc::clone(&self.shared));
        self.next += 1;
        let worker = std::thread::Builder::new().name(format!("edit-{number}"));
        let started = worker.spawn(move || Worker { number, shared, child: None }.work());
        let handle = started.map_err(|e| BatchError::Input(format!("a thread cannot be started: {e}")))?;
        self.workers.insert(number, handle);
        Ok(())
    }

    /// Joins workers that have ended.
    fn join_ended(&mut self) {
        let ended: Vec<usize> = self.workers.iter().filter(|(_, w)| w.is_finished()).map(|(n, _)| *n).collect();
        for number in ended {
            let _ = self.workers.remove(&number).map(JoinHandle::join);
        }
    }

    /// Abandons workers whose run exceeds its time limit by [`GRACE`]: the run counts as failed, and a new worker replaces them.
    fn abandon_hanging(&mut self) -> Result<(), BatchError> {
        let Some(limit) = self.shared.sweep.limits.seconds else { return Ok(()) };
        let deadline = Duration::from_secs_f64(limit) + GRACE;
        let shared = Arc::clone(&self.shared);
        let mut state = shared.lock();
        let hangs = |running: &Running| !running.task.isolated && running.began.elapsed() > deadline;
        let hanging: Vec<usize> = state.running.iter().filter(|(_, r)| hangs(r)).map(|(n, _)| *n).collect();
        for number in hanging {
            let Some(Running { mut task, key, began }) = state.running.remove(&number) else { continue };
            self.workers.remove(&number);
            self.abandoned += 1;
            // A retry in this process would leave another thread behind.
            task.isolated = task.isolated || shared.options.isolation.is_some();
            let seconds = EditSeconds { all: began.elapsed().as_secs_f64(), ..EditSeconds::default() };
            let result = EditResult::failed(Failure::time_limit(limit), &shared.sweep, seconds);
            let key = key.unwrap_or_else(|| Resolved::new(&shared.sweep, task.edit, &shared.keys).key);
            shared.end_edit(&mut state, task, key, result);
            self.start_worker()?;
        }
        Ok(())
    }
}

impl State {
    /// Takes the next run from the queue; `None` if there is none, or no memory for it yet.
    fn next_task(&mut self) -> Option<Task> {
        let elapsed = self.running.values().map(|running| running.began.elapsed()).max().unwrap_or_default();
        let is_admitted = !self.queue.is_empty() && self.admission.try_admit(self.running.len(), elapsed);
        if is_admitted { self.queue.pop_front() } else { None }
    }
}

impl Shared {
    /// Writes the row of a run, or returns it to the queue for a retry.
    fn end_edit(&self, state: &mut State, task: Task, key: EditKey, result: EditResult) {
        let failed = result.failure.as_ref().map(|failure| failure.class);
        state.step_seconds += result.seconds.steps;
        state.edit_seconds += result.seconds.all;
        if failed.is_some_and(|class| class.is_retried()) && task.attempts < self.sweep.limits.retries {
            state.queue.push_back(Task { attempts: task.attempts + 1, ..task });
        } else {
            let text = self.row(task.edit, &key, &result);
            let (attempts, seconds) = (task.attempts + 1, result.seconds);
            let row = NewRow { edit: task.edit, key, text: &text, failed, attempts, seconds };
            match state.files.put(row) {
                Ok(()) => {
                    state.progress.done += 1;
                    state.progress.new += 1;
                    state.progress.failed += u64::from(failed.is_some());
                }
                Err(error) => _ = state.error.get_or_insert(error),
            }
        }
        self.changed.notify_all();
    }

    /// The row of a run.
    fn row(&self, edit: u64, key: &EditKey, result: &EditResult) -> String {
        let mut cells = vec![Value::from(edit), Value::from(key.to_string())];
        cells.extend(self.sweep.edit(edit).cells);
        match &result.failure {
            None => cells.extend([Value::from("done"), Value::Null, Value::Null]),
            Some(failure) => {
                let (class, message) = (failure.class.name(), failure.message.as_str());
                cells.extend([Value::from("failed"), class.into(), message.into()]);
            }
        }
        cells.extend(result.cells.iter().cloned());
        row_json(self.sweep.columns(), &cells)
    }
}

/// A thread that executes runs.
struct Worker {
    /// Number of the worker, the key of its run in [`State::running`].
    number: usize,
    /// Data of all workers.
    shared: Arc<Shared>,
    /// The child process of its isolated runs.
    child: Option<ChildRunner>,
}

impl Worker {
    /// Executes runs until there are none left.
    fn work(mut self) {
        while let Some(task) = self.take() {
            let began = Instant::now();
            let shared = Arc::clone(&self.shared);
            let resolved = Resolved::new(&shared.sweep, task.edit, &shared.keys);
            let key = resolved.key.clone();
            if let Some(running) = shared.lock().running.get_mut(&self.number) {
                running.key = Some(key.clone());
            }
            let result = self.run(task, resolved, began);
            let mut state = shared.lock();
            // An abandoned run has a row already.
            if state.running.remove(&self.number).is_none() {
                return;
            }
            match result {
                Ok(Some(result)) => shared.end_edit(&mut state, task, key, result),
                Ok(None) => shared.changed.notify_all(),
                Err(error) => {
                    state.error.get_or_insert(error);
                    shared.changed.notify_all();
                }
            }
        }
    }

    /// Takes the next run and records its start; `None` if there is none left or the batch ends.
    fn take(&self) -> Option<Task> {
        let shared = &*self.shared;
        let mut state = shared.lock();
        loop {
            if shared.stopped() || state.error.is_some() {
                return None;
            }
            if let Some(task) = state.next_task() {
                if let Err(error) = state.files.begin_edit(task.edit, task.attempts + 1) {
                    state.error.get_or_insert(error);
                    return None;
                }
                state.running.insert(self.number, Running { task, key: None, began: Instant::now() });
                return Some(task);
            }
            // Active runs may return to the queue for a retry.
            if state.running.is_empty() {
                return None;
            }
            let waited = shared.changed.wait_timeout(state, TICK);
            state = waited.map_or_else(|poisoned| poisoned.into_inner().0, |(state, _)| state);
        }
    }

    /// Executes a run in this process or in a child; `None` if the batch was stopped.
    fn run(&mut self, task: Task, resolved: Resolved, began: Instant) -> Result<Option<EditResult>, BatchError> {
        let shared = &*self.shared;
        let stop = || shared.stopped();
        let on_open = |memory: u64| {
            shared.lock().admission.update(memory);
            shared.changed.notify_all();
        };
        match (&shared.options.isolation, task.isolated) {
            (Some(isolation), true) => {
                let child = self.child.get_or_insert_with(|| ChildRunner::new(isolation.clone()));
                child.run(&shared.sweep, &resolved, &on_open, &stop)
            }
            _ => EditRunner::new(&shared.sweep, &shared.options, &shared.meshes, &shared.parts, &on_open)
                .run(&resolved, began, &stop),
        }
    }
}
