//! The Python object of a session that goes on by the clock.

use super::failure::{Failure, Kind};
use super::live::{Ended, LiveThread, UsedPose, View};
use super::session::Session;
use super::states::{hand_pose, tool_dict};
use numpy::PyReadwriteArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// A session that goes on by the clock; stopping gives it back to its [`Session`].
#[pyclass(frozen, module = "pliant._native")]
pub struct Live {
    thread: Mutex<Option<LiveThread>>,
    session: Py<Session>,
    /// Names of the bodies that move.
    bodies: Vec<String>,
    tools: Vec<String>,
}

impl Live {
    /// Of a thread that has the session of `session`.
    pub fn of(thread: LiveThread, session: Py<Session>, bodies: Vec<String>, tools: Vec<String>) -> Self {
        Self { thread: Mutex::new(Some(thread)), session, bodies, tools }
    }

    /// Does something with the thread, which is there until it is stopped.
    fn with<R>(&self, act: impl FnOnce(&LiveThread) -> Result<R, Failure>) -> PyResult<R> {
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner);
        let stopped = || Failure::new(Kind::Closed, "it was stopped; allowed is to play the session anew");
        Ok(act(thread.as_ref().ok_or_else(stopped)?)?)
    }

    /// Reads the newest view.
    fn view<R>(&self, read: impl FnOnce(&View) -> Result<R, Failure>) -> PyResult<R> {
        self.with(|thread| thread.with_view(0, Duration::ZERO, read))
    }
}

fn index_of(names: &[String], what: &str, name: &str) -> Result<usize, Failure> {
    names.iter().position(|known| known == name).ok_or_else(|| {
        let known: Vec<String> = names.iter().map(|known| format!("`{known}`")).collect();
        Failure::argument(format!("no {what} `{name}`; allowed is {}", known.join(", ")))
    })
}

#[pymethods]
impl Live {
    /// Sends the hand of a tool somewhere, or away.
    fn place_hand(&self, tool: &str, position: Option<[f64; 3]>, rotation: [f64; 4], buttons: u32) -> PyResult<()> {
        self.with(|thread| {
            let pose = position.map(|position| hand_pose(position, rotation, buttons)).transpose()?;
            thread.go(index_of(&self.tools, "tool", tool)?, pose);
            Ok(())
        })
    }

    /// Waits for a view newer than the one of number `seen`, up to `seconds`; gives the number of the newest.
    fn wait(&self, py: Python<'_>, seen: u64, seconds: f64) -> PyResult<u64> {
        let patience = Duration::try_from_secs_f64(seconds).map_err(Failure::argument)?;
        py.detach(|| self.with(|thread| Ok(thread.with_view(seen, patience, |view| view.number))))
    }

    /// Number, simulated time (s), time that was given up (s), and whether the thread still goes on.
    fn state(&self) -> PyResult<(u64, f64, f64, bool)> {
        self.with(|thread| {
            let is_alive = thread.is_alive();
            Ok(thread.with_view(0, Duration::ZERO, |view| (view.number, view.time, view.lost_time, is_alive)))
        })
    }

    /// Number of triangles of a body in the newest view: another one says that it was cut.
    fn triangle_count(&self, body: &str) -> PyResult<usize> {
        let index = index_of(&self.bodies, "body", body)?;
        self.view(|view| Ok(view.triangles.get(index).copied().unwrap_or_default()))
    }

    /// Copies the newest positions of a body, as many as `out` (n x 3) has rows, each times `matrix` (3 x 4, row by row) if one is given.
    /// Gives the number of the view, 0 for none yet: `out` then stays as it is.
    #[pyo3(signature = (body, out, matrix=None))]
    fn read(&self, body: &str, mut out: PyReadwriteArray2<'_, f32>, matrix: Option<[[f32; 4]; 3]>) -> PyResult<u64> {
        let index = index_of(&self.bodies, "body", body)?;
        let given =
            out.as_slice_mut().map_err(|_| Failure::argument("the array is not contiguous; allowed is one that is"))?;
        let rows = given.as_chunks_mut::<3>().0;
        self.view(|view| {
            let Some(positions) = view.positions.get(index) else { return Ok(0) };
            if positions.len() < rows.len() {
                let (found, allowed) = (rows.len(), positions.len());
                return Err(Failure::argument(format!("the array has {found} rows; allowed is at most {allowed}")));
            }
            match matrix {
                None => rows.copy_from_slice(&positions[..rows.len()]),
                Some(matrix) => {
                    for (to, &[x, y, z]) in rows.iter_mut().zip(positions) {
                        *to = matrix.map(|[a, b, c, d]| a * x + b * y + c * z + d);
                    }
                }
            }
            Ok(view.number)
        })
    }

    /// The tool in the newest view as a dict: places and forces as tuples.
    fn tool<'py>(&self, py: Python<'py>, tool: &str) -> PyResult<Bound<'py, PyDict>> {
        let index = index_of(&self.tools, "tool", tool)?;
        let felt = self.view(|view| Ok(view.tools.get(index).copied().unwrap_or_default()))?;
        tool_dict(py, &felt, &self.bodies)
    }

    /// Ends the thread; the session goes on step by step. Gives the poses that hands had: index of the step's end in time (s), tool, place,
    /// turn and buttons.
    #[allow(clippy::type_complexity, reason = "a row of a table")]
    fn stop(&self, py: Python<'_>) -> PyResult<Vec<(f64, String, [f64; 3], [f64; 4], u32)>> {
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(thread) = thread else { return Ok(Vec::new()) };
        let ended = py.detach(|| thread.stop());
        let session = self.session.get();
        let Ended { mut open, used, done } = match ended {
            Ok(ended) => ended,
            Err(failure) => {
                session.end_live(None);
                return Err(failure.into());
            }
        };
        open.invalidate(py);
        session.end_live(done.is_ok().then_some(open));
        done?;
        let row = |used: &UsedPose| {
            let pose = used.pose;
            let tool = self.tools.get(used.tool).cloned().unwrap_or_default();
            (used.time, tool, pose.position.into(), pose.rotation.coords.into(), pose.buttons)
        };
        Ok(used.iter().map(row).collect())
    }
}
