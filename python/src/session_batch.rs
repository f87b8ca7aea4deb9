//! Many sessions that Python steps together.

use super::arrays::copy_vectors;
use super::failure::{Failure, Kind, contained};
use super::law::check_signals;
use super::model::Found;
use super::open::{OpenOptions, SceneText, load};
use super::states::hand_pose;
use numpy::{PyArray1, PyArray2};
use pliant_batch::{InstanceRun, SceneInstance, SessionBatch as EngineBatch};
use pliant_engine::session::{Session, ToolFrame};
use pliant_solver::Vec3;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::{Duration, Instant};

/// Time after which Python is asked whether the user wants to stop.
const SIGNAL_PERIOD: Duration = Duration::from_millis(20);

/// Sessions of one kind, stepped together; used by one thread at a time.
#[pyclass(frozen, module = "pliant._native")]
pub struct SessionBatch {
    batch: Mutex<EngineBatch>,
    process: u32,
}

impl SessionBatch {
    fn access(&self) -> Result<MutexGuard<'_, EngineBatch>, Failure> {
        if self.process != std::process::id() {
            let text =
                format!("the batch was opened by process {}; allowed is that one, not a fork of it", self.process);
            return Err(Failure::new(Kind::Closed, text));
        }
        match self.batch.try_lock() {
            Ok(batch) => Ok(batch),
            Err(TryLockError::WouldBlock) => {
                Err(Failure::new(Kind::Busy, "another thread is using the batch; allowed is one at a time"))
            }
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
        }
    }
}

/// A session that was not lost; names of bodies and tools are those of all.
fn any(batch: &EngineBatch) -> Result<&Session, Failure> {
    let first = (0..batch.len()).find_map(|number| batch.session(number));
    first.ok_or_else(|| Failure::new(Kind::Closed, "every instance was lost; see `failures`"))
}

/// The index of a tool in use.
fn tool_index(batch: &EngineBatch, name: &str) -> Result<usize, Failure> {
    let tools = &any(batch)?.tools;
    tools.iter().position(|slot| slot.tool.name == name).ok_or_else(|| {
        let known: Vec<String> = tools.iter().map(|slot| format!("`{}`", slot.tool.name)).collect();
        Failure::argument(format!("no tool `{name}` in use; allowed is {}", known.join(", ")))
    })
}

/// A tool of every instance at the end of the last step; not a number where an instance was lost.
fn felt(batch: &EngineBatch, tool: usize) -> Vec<ToolFrame> {
    let nowhere = Vec3::from_element(f64::NAN);
    let lost = ToolFrame {
        hand: nowhere,
        proxy: nowhere,
        force: nowhere,
        device_force: nowhere,
        depth: f64::NAN,
        ..ToolFrame::default()
    };
    let of = |number| match batch.session(number) {
        Some(session) => session.frame().tools.get(tool).copied().unwrap_or_default(),
        None => lost,
    };
    (0..batch.len()).map(of).collect()
}

#[pymethods]
impl SessionBatch {
    #[new]
    fn new(py: Python<'_>, scenes: Vec<SceneText>, options: OpenOptions, jobs: usize) -> PyResult<Self> {
        let open = || {
            let mut instances = Vec::with_capacity(scenes.len());
            for given in scenes {
                let (scene, source) = load(given)?;
                instances.push(SceneInstance { scene, source });
            }
            let opened = EngineBatch::open(instances, &options.search()?, jobs, &options.hands);
            opened.map_err(|(number, failure)| {
                let text = format!("instance {number}: {}", failure.message);
                Failure::new(Kind::Scene, text)
            })
        };
        let batch = py.detach(|| contained(open))?;
        Ok(Self { batch: Mutex::new(batch), process: std::process::id() })
    }

    /// Takes `count` steps of every instance. Ctrl-C is noticed between steps: all instances then have taken the same number.
    fn step(&self, py: Python<'_>, count: u64) -> PyResult<()> {
        let mut access = self.access()?;
        let batch = &mut *access;
        let (mut left, mut slice) = (count, 1);
        while left > 0 {
            let taken = slice.min(left);
            let began = Instant::now();
            py.detach(|| {
                contained(|| {
                    batch.step(taken, &AtomicBool::new(false));
                    Ok(())
                })
            })?;
            left -= taken;
            if began.elapsed() < SIGNAL_PERIOD / 2 {
                slice *= 2;
            }
            check_signals(py)?;
        }
        Ok(())
    }

    /// Steps every instance to its end: a dict of arrays for each.
    fn run<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let mut access = self.access()?;
        let batch = &mut *access;
        let (stop, mut raised) = (AtomicBool::new(false), None);
        let runs = py.detach(|| {
            let (sender, done) = channel();
            std::thread::scope(|scope| {
                let stop = &stop;
                scope.spawn(move || {
                    let runs = contained(|| Ok(batch.run(stop)));
                    let _ = sender.send(runs);
                });
                loop {
                    match done.recv_timeout(SIGNAL_PERIOD) {
                        Ok(runs) => return runs,
                        Err(RecvTimeoutError::Disconnected) => {
                            return Err(Failure::new(Kind::Panic, "the thread of the batch ended"));
                        }
                        Err(RecvTimeoutError::Timeout) => {
                            if let Err(error) = Python::attach(check_signals) {
                                raised.get_or_insert(error);
                                stop.store(true, Ordering::Relaxed);
                            }
                        }
                    }
                }
            })
        });
        match raised {
            Some(error) => Err(error),
            None => PyList::new(py, runs?.iter().map(|run| run_dict(py, run)).collect::<PyResult<Vec<_>>>()?),
        }
    }

    /// Number of instances.
    fn __len__(&self) -> PyResult<usize> {
        Ok(self.access()?.len())
    }

    /// Names of the tools in use.
    #[getter]
    fn tools(&self) -> PyResult<Vec<String>> {
        let batch = self.access()?;
        Ok(any(&batch)?.tools.iter().map(|slot| slot.tool.name.clone()).collect())
    }

    /// Names of the bodies, those that move first.
    #[getter]
    fn bodies(&self) -> PyResult<Vec<String>> {
        let batch = self.access()?;
        Ok(super::model::names(any(&batch)?).map(str::to_owned).collect())
    }

    /// Of every instance: s, simulated, and the number of steps taken; NaN and 0 where it was lost.
    #[allow(clippy::type_complexity, reason = "two arrays")]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<u64>>)> {
        let batch = self.access()?;
        let of = |number| batch.session(number).map_or((f64::NAN, 0), |session| (session.time(), session.steps()));
        let (times, steps): (Vec<f64>, Vec<u64>) = (0..batch.len()).map(of).unzip();
        Ok((PyArray1::from_vec(py, times), PyArray1::from_vec(py, steps)))
    }

    /// A tool of every instance: places in m and forces in N (n x 3), depth in m (n), whether it holds on (n).
    fn tool<'py>(&self, py: Python<'py>, tool: &str) -> PyResult<Bound<'py, PyDict>> {
        let batch = self.access()?;
        let felt = felt(&batch, tool_index(&batch, tool)?);
        let vectors = |of: fn(&ToolFrame) -> Vec3| copy_vectors(py, &felt.iter().map(of).collect::<Vec<_>>());
        let dict = PyDict::new(py);
        dict.set_item("hand", vectors(|tool| tool.hand))?;
        dict.set_item("proxy", vectors(|tool| tool.proxy))?;
        dict.set_item("force", vectors(|tool| tool.force))?;
        dict.set_item("depth", PyArray1::from_iter(py, felt.iter().map(|tool| tool.depth)))?;
        dict.set_item("touches", PyArray1::from_iter(py, felt.iter().map(|tool| tool.contact.is_some())))?;
        dict.set_item("holds", PyArray1::from_iter(py, felt.iter().map(|tool| tool.grips)))?;
        Ok(dict)
    }

    /// Puts the hands of a tool somewhere: a place (m), a turn (x, y, z, w) and buttons for each instance, or none for a hand that is away.
    fn place_hands(
        &self,
        tool: &str,
        positions: Vec<Option<[f64; 3]>>,
        rotations: Vec<[f64; 4]>,
        buttons: Vec<u32>,
    ) -> PyResult<()> {
        let mut batch = self.access()?;
        let index = tool_index(&batch, tool)?;
        for (number, ((position, rotation), buttons)) in positions.into_iter().zip(rotations).zip(buttons).enumerate() {
            let pose = position.map(|position| hand_pose(position, rotation, buttons)).transpose()?;
            batch.place_hand(number, index, pose);
        }
        Ok(())
    }

    /// m (v x 3), places of the vertices of a body of every instance; `None` where it was lost.
    fn positions<'py>(&self, py: Python<'py>, body: &str) -> PyResult<Vec<Option<Bound<'py, PyArray2<f64>>>>> {
        let mut access = self.access()?;
        let batch = &mut *access;
        py.detach(|| {
            contained(|| {
                batch.update_surfaces();
                Ok(())
            })
        })?;
        Found::named(any(batch)?, body)?;
        let of = |number| {
            let session = batch.session(number)?;
            Found::named(session, body).ok().map(|found| copy_vectors(py, found.positions()))
        };
        Ok((0..batch.len()).map(of).collect())
    }

    /// What went wrong, by number of the instance: class and sentence.
    fn failures(&self) -> PyResult<Vec<(usize, &'static str, String)>> {
        let failures = self.access()?.failures();
        Ok(failures.into_iter().map(|(number, failure)| (number, failure.class.name(), failure.message)).collect())
    }
}

/// What the run of an instance came to.
fn run_dict<'py>(py: Python<'py>, run: &InstanceRun) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("time", PyArray1::from_slice(py, &run.time))?;
    let tools = PyDict::new(py);
    for series in &run.tools {
        let tool = PyDict::new(py);
        tool.set_item("hand", copy_vectors(py, &series.hand))?;
        tool.set_item("depth", PyArray1::from_slice(py, &series.depth))?;
        tool.set_item("force", copy_vectors(py, &series.force))?;
        tools.set_item(&series.name, tool)?;
    }
    dict.set_item("tools", tools)?;
    let probes = PyDict::new(py);
    for probe in &run.probes {
        probes.set_item(&probe.name, probe.value)?;
    }
    dict.set_item("probes", probes)?;
    Ok(dict)
}
