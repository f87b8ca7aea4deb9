//! A session that Python steps.

use super::arrays::{copy_rows, copy_vectors};
use super::ctrl_c::CtrlC;
use super::failure::{Failure, Kind, contained};
use super::law::check_signals;
use super::lease::lend;
use super::live::LiveThread;
use super::live_device::{Lead, LeadDevice, check_tool};
use super::live_object::{GivenWish, Live};
use super::model::{Found, names};
use super::open::{OpenOptions, Opened, SceneText, open};
use super::open_session::Open;
use super::painting::Painting;
use super::states::{frame_dict, hand_pose, tool_dict};
use numpy::{PyArray1, PyArray2};
use pliant_editor::{DeviceRequest, DeviceView, DeviceWish};
use pliant_engine::body::{Body, Division};
use pliant_engine::session::{CancelToken, HistoryCounts, Session as EngineSession, Snapshot as EngineSnapshot};
use pliant_record::{PlanReport, write_model};
use pliant_solver::Vec3;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::json;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::{Duration, Instant};

/// How long steps are taken before Python is asked whether the user wants to stop.
const SIGNAL_PERIOD: Duration = Duration::from_millis(20);
/// Buttons of the scene that are pressed by default while no button of a device is, while its first is, and while only another is: none, button 0 and button 1
/// (bit i is button i).
const DEFAULT_BUTTONS: [u32; 3] = [0, 1 << 0, 1 << 1];

/// All bodies of a session at one moment.
#[pyclass(frozen, module = "pliant._native")]
pub struct Snapshot {
    snapshot: EngineSnapshot,
    /// Of the session it was taken from.
    session: u64,
}

/// An opened scene; used by one thread at a time.
#[pyclass(frozen, weakref, module = "pliant._native")]
pub struct Session {
    open: Mutex<Option<Open>>,
    /// Whether it goes on by the clock, elsewhere.
    is_live: AtomicBool,
    /// Distinguishes sessions of a process.
    number: u64,
    process: u32,
}

impl Drop for Session {
    fn drop(&mut self) {
        // After a fork the threads of the session are the parent's: it cannot be ended here.
        if self.process != std::process::id() {
            let open = self.open.get_mut().unwrap_or_else(std::sync::PoisonError::into_inner);
            std::mem::forget(open.take());
        }
    }
}

/// A session for a time in which no other thread uses it.
struct Access<'a>(MutexGuard<'a, Option<Open>>);

impl Access<'_> {
    fn open(&mut self) -> Result<&mut Open, Failure> {
        self.0
            .as_mut()
            .ok_or_else(|| Failure::new(Kind::Closed, "the session is closed; allowed is nothing but opening it anew"))
    }
}

impl Session {
    /// The Python object of an open session.
    pub fn of(open: Open) -> Self {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let (open, is_live) = (Mutex::new(Some(open)), AtomicBool::new(false));
        Self { open, is_live, number, process: std::process::id() }
    }

    /// Takes the session back from a thread; `None` if it ended with a fault.
    pub fn end_live(&self, open: Option<Open>) {
        *self.open.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = open;
        self.is_live.store(false, Ordering::Relaxed);
    }

    fn access(&self) -> Result<Access<'_>, Failure> {
        if self.process != std::process::id() {
            let text =
                format!("the session was opened by process {}; allowed is that one, not a fork of it", self.process);
            return Err(Failure::new(Kind::Closed, text));
        }
        if self.is_live.load(Ordering::Relaxed) {
            let text = "the session goes on by the clock; allowed is to stop that first, or what its `Live` offers";
            return Err(Failure::new(Kind::Busy, text));
        }
        match self.open.try_lock() {
            Ok(open) => Ok(Access(open)),
            Err(TryLockError::WouldBlock) => {
                let text = "another thread is using the session; allowed is one at a time";
                Err(Failure::new(Kind::Busy, text))
            }
            Err(TryLockError::Poisoned(_)) => {
                Err(Failure::new(Kind::Closed, "the session ended with a fault of the program"))
            }
        }
    }

    /// Reads something of the session.
    fn read<R>(&self, read: impl FnOnce(&mut Open) -> Result<R, Failure>) -> PyResult<R> {
        let mut access = self.access()?;
        let open = access.open()?;
        Ok(contained(|| read(open))?)
    }

    /// Changes positions, without the interpreter's lock; after a fault the session is closed.
    fn change<R: Send>(
        &self,
        py: Python<'_>,
        change: impl FnOnce(&mut EngineSession) -> Result<R, Failure> + Send,
    ) -> PyResult<R> {
        let mut access = self.access()?;
        let open = access.open()?;
        open.invalidate(py);
        let session = &mut open.opened.session;
        let done = py.detach(|| contained(|| change(session)));
        if done.as_ref().is_err_and(Failure::is_panic) {
            *access.0 = None;
        }
        Ok(done?)
    }
}

/// Goes on in real time, with a device that has a hand where one is given.
fn go_live(this: &Bound<'_, Session>, mut access: Access<'_>, lead: Option<Lead>) -> PyResult<Live> {
    access.open()?.invalidate(this.py());
    let Some(open) = access.0.take() else { return Err(access.open().err().expect("it is closed").into()) };
    let bodies = open.opened.session.bodies.iter().map(|body| body.name.clone()).collect();
    let tools = open.opened.session.tools.iter().map(|slot| slot.tool.name.clone()).collect();
    match LiveThread::start(open, lead) {
        Ok(thread) => {
            this.get().is_live.store(true, Ordering::Relaxed);
            Ok(Live::of(thread, this.clone().unbind(), bodies, tools))
        }
        Err((open, failure)) => {
            *access.0 = Some(*open);
            Err(failure.into())
        }
    }
}

/// Middle of the box around all bodies that move, m; the origin without any.
fn middle_of(session: &EngineSession) -> Vec3 {
    let points = || session.bodies.iter().flat_map(|body| body.model.surface.points.iter());
    let Some(first) = points().next() else { return Vec3::zeros() };
    let (low, high) = points().fold((*first, *first), |(low, high), point| (low.inf(point), high.sup(point)));
    0.5 * (low + high)
}

/// What strokes have pinned and painted on a body.
fn painting(open: &Open, body: &str) -> Result<Painting, Failure> {
    match Found::named(&open.opened.session, body)? {
        Found::Moving(_, body) => Painting::of(body),
        Found::Standing(_) => Ok(Painting::default()),
    }
}

/// The triangle of the model that is a row of [`Session::triangles`].
fn seen_triangle(body: &Body, row: u32) -> Result<u32, Failure> {
    let found = Found::Moving(0, body);
    found.triangles().nth(row as usize).ok_or_else(|| {
        let (name, count) = (&body.name, found.triangles().count());
        Failure::argument(format!(
            "body `{name}` has no triangle {row}; allowed is a row of `triangles()`, 0 to {}",
            count - 1
        ))
    })
}

#[pymethods]
impl Session {
    #[new]
    fn new(py: Python<'_>, scene: SceneText, options: OpenOptions) -> PyResult<Self> {
        let began = Instant::now();
        let opened = py.detach(|| contained(|| open(scene, &options)))?;
        Ok(Self::of(Open::new(opened, began.elapsed())))
    }

    /// Takes `count` steps. Ctrl-C ends the step under way, which is then not taken.
    fn step(&self, py: Python<'_>, count: u64) -> PyResult<()> {
        let ctrl_c = CtrlC::watch();
        let mut left = count;
        while left > 0 {
            let taken = self.change(py, |session| {
                session.cancel_when(ctrl_c.token());
                let (began, mut taken) = (Instant::now(), 0);
                while taken < left && (taken == 0 || began.elapsed() < SIGNAL_PERIOD) {
                    session.step();
                    if session.is_cancelled() {
                        break;
                    }
                    taken += 1;
                }
                session.cancel_when(CancelToken::default());
                Ok(taken)
            })?;
            left -= taken;
            ctrl_c.clear();
            check_signals(py)?;
        }
        Ok(())
    }

    /// Goes on by the clock on a thread of its own until the result is stopped.
    fn play(this: &Bound<'_, Self>) -> PyResult<Live> {
        go_live(this, this.get().access()?, None)
    }

    /// Goes on in real time with a device that has the hand of a tool, until the result is stopped. `params` are keys and texts of parameters of its plugin.
    /// What is not given is the default: the middle of the bodies, no turn, a button of the scene for each of the device, all of the force.
    fn follow(
        this: &Bound<'_, Self>,
        tool: &str,
        plugin: String,
        params: Vec<(String, String)>,
        given: GivenWish,
    ) -> PyResult<Live> {
        let (py, mut access) = (this.py(), this.get().access()?);
        let open = access.open()?;
        let tool = open.tool(tool)?;
        let Opened { session, search, .. } = &open.opened;
        check_tool(session, tool)?;
        let view = DeviceView { centre: middle_of(session), rotation: Default::default() };
        let mut wish = DeviceWish { view, buttons: DEFAULT_BUTTONS, force_share: 1.0 };
        given.apply(&mut wish)?;
        let request = DeviceRequest { plugin: plugin.clone(), settings: params, ..DeviceRequest::default() };
        // Drivers of arms take their time.
        let (dt, search) = (session.dt(), search.clone());
        let opened =
            py.detach(|| contained(|| request.open(&search, dt).map_err(|error| Failure::new(Kind::Plugin, error))))?;
        go_live(this, access, Some(Lead { tool, device: LeadDevice::Opened(opened), name: plugin, wish }))
    }

    /// Goes on in real time with the device that had a hand of another session and was kept when that was stopped. What is `None` stays as it was asked for last.
    fn follow_on(this: &Bound<'_, Self>, tool: &str, before: &Live, given: GivenWish) -> PyResult<Live> {
        let mut access = this.get().access()?;
        let open = access.open()?;
        let tool = open.tool(tool)?;
        check_tool(&open.opened.session, tool)?;
        let Some(mut kept) = before.take_kept() else {
            let text = "the hand has no device: it was lost, closed, or has gone to another session; allowed is the name of a device";
            return Err(Failure::argument(text).into());
        };
        given.apply(&mut kept.wish)?;
        let (name, wish) = (kept.name.clone(), kept.wish);
        go_live(this, access, Some(Lead { tool, device: LeadDevice::Kept(Box::new(kept)), name, wish }))
    }

    /// Ends the session; arrays of its positions stay as they are.
    fn close(&self) -> PyResult<()> {
        if self.process == std::process::id() {
            *self.access()?.0 = None;
        }
        Ok(())
    }

    /// Whether it is closed.
    #[getter]
    fn closed(&self) -> bool {
        self.open.try_lock().is_ok_and(|open| open.is_none())
    }

    /// Counts changes of positions.
    #[getter]
    fn version(&self) -> PyResult<u64> {
        self.read(|open| Ok(open.version))
    }

    /// s, simulated time
    #[getter]
    fn time(&self) -> PyResult<f64> {
        self.read(|open| Ok(open.opened.session.time()))
    }

    /// s, one step
    #[getter]
    fn dt(&self) -> PyResult<f64> {
        self.read(|open| Ok(open.opened.session.dt()))
    }

    /// Number of steps taken since the start.
    #[getter]
    fn steps(&self) -> PyResult<u64> {
        self.read(|open| Ok(open.opened.session.steps()))
    }

    /// Steps of the scene's duration.
    #[getter]
    fn planned_steps(&self) -> PyResult<u64> {
        self.read(|open| Ok(open.opened.scene.time.steps()))
    }

    /// Names of the bodies, those that move first.
    #[getter]
    fn bodies(&self) -> PyResult<Vec<String>> {
        self.read(|open| Ok(names(&open.opened.session).map(str::to_owned).collect()))
    }

    /// Names of the tools in use.
    #[getter]
    fn tools(&self) -> PyResult<Vec<String>> {
        self.read(|open| Ok(open.opened.session.tools.iter().map(|slot| slot.tool.name.clone()).collect()))
    }

    /// m (n x 3), an array that shows the positions of a body without a copy
    fn positions<'py>(&self, py: Python<'py>, body: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let mut access = self.access()?;
        let open = access.open()?;
        open.embed(py)?;
        match Found::named(&open.opened.session, body)? {
            Found::Moving(index, moving) => {
                let (array, lent) = lend(py, &moving.skin.x, index)?;
                open.lent.push(lent);
                Ok(array)
            }
            standing @ Found::Standing(_) => Ok(copy_vectors(py, standing.positions())),
        }
    }

    /// m (n x 3), a copy of where the vertices of a body are when it is at rest
    fn rest_positions<'py>(&self, py: Python<'py>, body: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.read(|open| {
            let found = Found::named(&open.opened.session, body)?;
            Ok(copy_vectors(py, &found.model().surface.points))
        })
    }

    /// Vertices of the triangles of a body (m x 3)
    fn triangles<'py>(&self, py: Python<'py>, body: &str) -> PyResult<Bound<'py, PyArray2<u32>>> {
        self.read(|open| {
            let found = Found::named(&open.opened.session, body)?;
            let triangles = &found.model().surface.triangles;
            Ok(copy_rows(py, found.triangles().map(|t| triangles[t as usize]), triangles.len()))
        })
    }

    /// Face of the model that each triangle is a part of (m); the number of faces for a triangle of a cut's inside
    fn face_of<'py>(&self, py: Python<'py>, body: &str) -> PyResult<Bound<'py, PyArray1<u32>>> {
        self.read(|open| {
            let found = Found::named(&open.opened.session, body)?;
            let face_of = &found.model().surface.face_of;
            Ok(PyArray1::from_vec(py, found.triangles().map(|t| face_of[t as usize]).collect()))
        })
    }

    /// Vertices that strokes have pinned, ascending
    fn pinned<'py>(&self, py: Python<'py>, body: &str) -> PyResult<Bound<'py, PyArray1<u32>>> {
        self.read(|open| Ok(painting(open, body)?.pinned_array(py)))
    }

    /// Vertices whose parameter strokes have painted, ascending, and the factor of each
    #[allow(clippy::type_complexity, reason = "two arrays")]
    fn painted<'py>(
        &self,
        py: Python<'py>,
        body: &str,
        param: &str,
    ) -> PyResult<(Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>)> {
        self.read(|open| painting(open, body)?.painted_arrays(py, param))
    }

    /// m (n x 3), m/s (n x 3) and kg (n): copies of places, velocities and masses of a body's simulated nodes
    #[allow(clippy::type_complexity, reason = "three arrays")]
    fn nodes<'py>(
        &self,
        py: Python<'py>,
        body: &str,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>)> {
        self.read(|open| {
            let Found::Moving(_, body) = Found::named(&open.opened.session, body)? else {
                return Ok((copy_vectors(py, &[]), copy_vectors(py, &[]), PyArray1::from_vec(py, Vec::new())));
            };
            let nodes = &body.system.nodes;
            let mass = PyArray1::from_slice(py, &nodes.mass);
            Ok((copy_vectors(py, &nodes.x), copy_vectors(py, &nodes.v), mass))
        })
    }

    /// The end of the last step as a dict of numbers.
    fn frame<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mut access = self.access()?;
        frame_dict(py, access.open()?.opened.session.frame())
    }

    /// The tool at the end of the last step as a dict: places and forces as tuples.
    fn tool<'py>(&self, py: Python<'py>, tool: &str) -> PyResult<Bound<'py, PyDict>> {
        let mut access = self.access()?;
        let open = access.open()?;
        let index = open.tool(tool)?;
        let felt = open.opened.session.frame().tools.get(index).copied().unwrap_or_default();
        let bodies: Vec<String> = open.opened.session.bodies.iter().map(|body| body.name.clone()).collect();
        tool_dict(py, &felt, &bodies)
    }

    /// Puts the hand of a tool somewhere, or takes it away: place (m) and turn (x, y, z, w) in the scene, buttons as bits.
    #[pyo3(signature = (tool, position, rotation, buttons))]
    fn place_hand(&self, tool: &str, position: Option<[f64; 3]>, rotation: [f64; 4], buttons: u32) -> PyResult<()> {
        self.read(|open| {
            let index = open.tool(tool)?;
            let pose = position.map(|position| hand_pose(position, rotation, buttons)).transpose()?;
            open.opened.session.place_hand(index, pose);
            Ok(())
        })
    }

    /// Takes back the last edit that can be; gives whether there was one.
    fn undo(&self, py: Python<'_>) -> PyResult<bool> {
        self.change(py, |session| Ok(session.undo()))
    }

    /// Makes again what was taken back last; gives whether there was anything.
    fn redo(&self, py: Python<'_>) -> PyResult<bool> {
        self.change(py, |session| Ok(session.redo()))
    }

    /// Makes parts of a body bodies of their own: each, or the one with a triangle. Gives the names of the bodies that it is now.
    #[pyo3(signature = (body, triangle))]
    fn split(&self, py: Python<'_>, body: &str, triangle: Option<u32>) -> PyResult<Vec<String>> {
        self.change(py, |session| {
            let Found::Moving(index, _) = Found::named(session, body)? else {
                let text = format!("body `{body}` does not move and is in one piece; allowed is a body that moves");
                return Err(Failure::argument(text));
            };
            let division = match triangle {
                None => Division::EachPart,
                Some(triangle) => Division::PartOf(seen_triangle(&session.bodies[index], triangle)?),
            };
            let bodies = session.split(index, division).map_err(Failure::argument)?;
            Ok(bodies.into_iter().map(|body| session.bodies[body].name.clone()).collect())
        })
    }

    /// Edits that can be taken back, and made again.
    #[getter]
    fn history(&self) -> PyResult<(usize, usize)> {
        self.read(|open| {
            let HistoryCounts { done, undone } = open.opened.session.history();
            Ok((done, undone))
        })
    }

    /// All bodies as they are now.
    fn snapshot(&self) -> PyResult<Snapshot> {
        self.read(|open| Ok(Snapshot { snapshot: open.opened.session.snapshot(), session: self.number }))
    }

    /// Goes back to a snapshot of this session.
    fn restore(&self, py: Python<'_>, snapshot: &Bound<'_, Snapshot>) -> PyResult<()> {
        let snapshot = snapshot.get();
        if snapshot.session != self.number {
            return Err(Failure::argument("a snapshot of another session; allowed is one of this session").into());
        }
        self.change(py, |session| Ok(session.restore(&snapshot.snapshot)?))
    }

    /// What a run will do, as JSON.
    fn plan(&self) -> PyResult<String> {
        self.read(|open| {
            let Opened { scene, session, .. } = &open.opened;
            let report = PlanReport::new(session, scene.time.steps(), open.opening);
            serde_json::to_string(&report).map_err(|error| Failure::new(Kind::Panic, error))
        })
    }

    /// What happened so far, as JSON: counts by kind, and the described ones.
    fn events(&self) -> PyResult<String> {
        self.read(|open| {
            let events = &open.opened.session.events;
            let described = events
                .described()
                .iter()
                .map(|(kind, event)| json!({ "kind": kind, "time": event.time, "text": event.text }));
            Ok(json!({ "counts": events.counts(), "described": described.collect::<Vec<_>>() }).to_string())
        })
    }

    /// What has no effect, or not the one it looks like, as JSON: code, place and sentence of each.
    fn warnings(&self) -> PyResult<String> {
        self.read(|open| {
            let warnings = open.opened.session.warnings();
            serde_json::to_string(&warnings).map_err(|error| Failure::new(Kind::Panic, error))
        })
    }

    /// Writes the model of a body as an OBJ file.
    fn write(&self, py: Python<'_>, body: &str, path: PathBuf) -> PyResult<()> {
        let mut access = self.access()?;
        let open = access.open()?;
        open.embed(py)?;
        let session = &mut open.opened.session;
        let write = || {
            let session = &*session;
            match Found::named(session, body)? {
                Found::Moving(_, body) => Ok(write_model(body, &session.plan().cap_material, &path)?),
                Found::Standing(model) => Ok(std::fs::write(&path, model.document.bytes())?),
            }
        };
        Ok(contained(write)?)
    }
}
