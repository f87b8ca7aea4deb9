//! Many open sessions that are stepped together; the caller reads and controls all of them between steps.

use crate::execute::{Failure, FailureClass, MODELS_KEPT};
use pliant_engine::plan::Plan;
use pliant_engine::scene::{Scene, Source};
use pliant_engine::session::{HandPose, Options, Session, SharedParts};
use pliant_host::SearchPath;
use pliant_mesh::geometry::Vec3;
use pliant_record::{ProbeResult, RunStatistics};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A scene and its source.
pub struct SceneInstance {
    /// Scene with its parameters set.
    pub scene: Scene,
    /// Its text and models.
    pub source: Source,
}

/// One session of a batch.
struct Instance {
    /// The scene's source.
    source: Source,
    /// Number of steps of the scene.
    planned_steps: u64,
    /// `None` once a step panicked.
    session: Option<Session>,
    /// The failure of a session that was lost.
    lost: Option<Failure>,
}

/// Quantities of a tool in a run, a value for each step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolSeries {
    /// Name of the tool.
    pub name: String,
    /// Position of the hand, m (steps x 3).
    pub hand: Vec<Vec3>,
    /// Depth to which the surface is pushed in, or pulled out, m (steps).
    pub depth: Vec<f64>,
    /// Force on the hand, N (steps x 3).
    pub force: Vec<Vec3>,
}

/// Results of the run of an instance.
#[derive(Clone, Debug, Default)]
pub struct InstanceRun {
    /// Time at the end of each step, s.
    pub time: Vec<f64>,
    /// Tools, in the order of the session.
    pub tools: Vec<ToolSeries>,
    /// Probes, in the order of the scene.
    pub probes: Vec<ProbeResult>,
}

/// Many open sessions, which share models and grids. Each is stepped by one thread at a time.
///
/// An instance gives the same bytes as a session on its own, for any number of threads. An instance whose step panics is lost, and the others go
/// on; see [`SessionBatch::failures`].
pub struct SessionBatch {
    /// The sessions, in the order in which their scenes were given.
    instances: Vec<Instance>,
    /// Number of threads.
    jobs: usize,
}

impl SessionBatch {
    /// Opens a session for each scene with `jobs` threads; 0 for the number of processors. `hands` names devices whose hands are absent until
    /// [`SessionBatch::place_hand`] is called.
    ///
    /// # Errors
    /// Returns the index and the failure of the first scene that cannot be opened.
    pub fn open(
        scenes: Vec<SceneInstance>,
        search: &SearchPath,
        jobs: usize,
        hands: &[String],
    ) -> Result<Self, (usize, Failure)> {
        let jobs = match jobs {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            jobs => jobs,
        };
        let parts = SharedParts::new(MODELS_KEPT);
        let open = |given: SceneInstance| {
            let SceneInstance { scene, source } = given;
            let plan = Plan::new(&scene, &source).map_err(|e| Failure::new(FailureClass::Scene, e))?;
            let options = Options::new(search.clone(), 1);
            let mut session =
                Session::open_shared(&scene, &source, plan, &options, &parts).map_err(|e| Failure::of_opening(&e))?;
            for tool in 0..session.tools.len() {
                if hands.contains(&session.devices[session.tools[tool].device].name) {
                    session.place_hand(tool, None);
                }
            }
            let planned_steps = scene.time.steps();
            Ok(Instance { source, planned_steps, session: Some(session), lost: None })
        };
        let opened = in_parallel(jobs, scenes, |given| catch_panic(|| open(given)));
        let mut instances = Vec::with_capacity(opened.len());
        for (number, instance) in opened.into_iter().enumerate() {
            instances.push(instance.map_err(|failure| (number, failure))?);
        }
        Ok(Self { instances, jobs })
    }

    /// Number of instances.
    pub fn len(&self) -> usize {
        self.instances.len()
    }

    /// Whether there is no instance.
    pub fn is_empty(&self) -> bool {
        self.instances.is_empty()
    }

    /// The session of an instance; `None` if it was lost.
    pub fn session(&self, number: usize) -> Option<&Session> {
        self.instances.get(number)?.session.as_ref()
    }

    /// Takes `count` steps of every instance, or fewer once `stop` is set; numbers of steps may then differ between instances.
    pub fn step(&mut self, count: u64, stop: &AtomicBool) {
        self.each(|_, session| {
            for _ in 0..count {
                if stop.load(Ordering::Relaxed) {
                    break;
                }
                session.step();
            }
        });
    }

    /// Steps every instance to the end of its scene or until `stop` is set. An instance that was lost has an empty run.
    pub fn run(&mut self, stop: &AtomicBool) -> Vec<InstanceRun> {
        let runs = self.each(|instance, session| run(instance, session, stop));
        runs.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// Sets the pose of the hand of a tool of an instance; `None` removes the hand.
    ///
    /// # Panics
    /// If the session does not have the tool.
    pub fn place_hand(&mut self, number: usize, tool: usize, pose: Option<HandPose>) {
        if let Some(session) = self.instances.get_mut(number).and_then(|instance| instance.session.as_mut()) {
            session.place_hand(tool, pose);
        }
    }

    /// Updates the surfaces of all instances.
    pub fn update_surfaces(&mut self) {
        self.each(|_, session| session.update_surface());
    }

    /// Indices and failures of the instances that were lost, or in which a body was frozen or a device was lost.
    pub fn failures(&self) -> Vec<(usize, Failure)> {
        let of_instance = |instance: &Instance| {
            instance.lost.clone().or_else(|| instance.session.as_ref().and_then(Failure::of_session))
        };
        self.instances.iter().enumerate().filter_map(|(number, i)| Some((number, of_instance(i)?))).collect()
    }

    /// Calls `work` with every session, in parallel; `None` for an instance that was lost.
    fn each<R: Send>(&mut self, work: impl Fn(&InstanceInfo<'_>, &mut Session) -> R + Sync) -> Vec<Option<R>> {
        in_parallel(self.jobs, self.instances.iter_mut().collect(), |instance: &mut Instance| {
            let Instance { source, planned_steps, session, lost } = instance;
            let info = InstanceInfo { source, planned_steps: *planned_steps };
            let open = session.as_mut()?;
            match catch_panic(|| Ok(work(&info, open))) {
                Ok(done) => Some(done),
                Err(failure) => {
                    (*session, *lost) = (None, Some(failure));
                    None
                }
            }
        })
    }
}

/// An instance without its session.
struct InstanceInfo<'a> {
    /// The scene's source.
    source: &'a Source,
    /// Number of steps of the scene.
    planned_steps: u64,
}

/// Steps a session to the end of its scene.
fn run(instance: &InstanceInfo<'_>, session: &mut Session, stop: &AtomicBool) -> InstanceRun {
    let mut figures = RunStatistics::new(instance.source, session, Instant::now());
    let series = |name: &String| ToolSeries { name: name.clone(), ..ToolSeries::default() };
    let mut tools: Vec<ToolSeries> = session.tools.iter().map(|slot| series(&slot.tool.name)).collect();
    let mut time = Vec::new();
    while session.steps() < instance.planned_steps && !stop.load(Ordering::Relaxed) {
        session.step();
        let last = session.steps() == instance.planned_steps;
        figures.step(session, last, false);
        let frame = session.frame();
        time.push(frame.time);
        for (series, tool) in tools.iter_mut().zip(&frame.tools) {
            series.hand.push(tool.hand);
            series.depth.push(tool.depth);
            series.force.push(tool.force);
        }
    }
    InstanceRun { time, tools, probes: figures.probes() }
}

/// Calls `work`; a panic in it becomes a failure.
fn catch_panic<R>(work: impl FnOnce() -> Result<R, Failure>) -> Result<R, Failure> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(Failure::of_panic(panic.as_ref())))
}

/// Calls `work` with each item on up to `jobs` threads; results are in the order of the items.
fn in_parallel<T: Send, R: Send>(jobs: usize, items: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let count = items.len();
    if jobs <= 1 || count <= 1 {
        return items.into_iter().map(work).collect();
    }
    let queue = Mutex::new(items.into_iter().enumerate());
    let results: Mutex<Vec<Option<R>>> = Mutex::new((0..count).map(|_| None).collect());
    let take = || queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).next();
    let worker = || {
        while let Some((number, item)) = take() {
            let done = work(item);
            results.lock().unwrap_or_else(|poisoned| poisoned.into_inner())[number] = Some(done);
        }
    };
    std::thread::scope(|scope| {
        // The calling thread is one of the workers, and the only one if the system gives no other.
        (1..jobs.min(count)).for_each(|_| _ = std::thread::Builder::new().spawn_scoped(scope, worker));
        worker();
    });
    let results = results.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    results.into_iter().map(|done| done.expect("every item was taken")).collect()
}
