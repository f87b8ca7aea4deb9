//! The Python object of a session that goes on by the clock.

use super::arrays::copy_rows;
use super::failure::{Failure, Kind};
use super::live::{Ended, LiveThread, UsedPose, View};
use super::live_device::{KeptDevice, LedHand};
use super::painting::Painting;
use super::session::Session;
use super::states::{hand_pose, tool_dict};
use numpy::{PyArray1, PyArray2, PyReadwriteArray2};
use pliant_editor::DeviceWish;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A session that goes on by the clock; stopping gives it back to its [`Session`].
#[pyclass(frozen, module = "pliant._native")]
pub struct Live {
    thread: Mutex<Option<LiveThread>>,
    /// The device that had a hand, for another session.
    kept: Mutex<Option<KeptDevice>>,
    session: Py<Session>,
    /// Names of the bodies that move.
    bodies: Vec<String>,
    tools: Vec<String>,
}

impl Live {
    /// A live session on a thread that has taken over the session of `session`.
    pub fn of(thread: LiveThread, session: Py<Session>, bodies: Vec<String>, tools: Vec<String>) -> Self {
        Self { thread: Mutex::new(Some(thread)), kept: Mutex::default(), session, bodies, tools }
    }

    /// The device that was kept when the thread was stopped.
    pub fn take_kept(&self) -> Option<KeptDevice> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Calls `act` with the thread; an error after it was stopped.
    fn with<R>(&self, act: impl FnOnce(&LiveThread) -> Result<R, Failure>) -> PyResult<R> {
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner);
        let stopped = || Failure::new(Kind::Closed, "it was stopped; allowed is to play the session anew");
        Ok(act(thread.as_ref().ok_or_else(stopped)?)?)
    }

    /// Reads the newest view.
    fn view<R>(&self, read: impl FnOnce(&View) -> Result<R, Failure>) -> PyResult<R> {
        self.with(|thread| thread.with_view(0, Duration::ZERO, read))
    }

    /// What strokes have pinned and painted on a body, in the newest view.
    fn painting(&self, body: &str) -> PyResult<Arc<Painting>> {
        let index = index_of(&self.bodies, "body", body)?;
        self.view(|view| {
            view.paintings.get(index).cloned().ok_or_else(|| {
                Failure::argument("nothing has been shown yet; allowed is to wait for the first view with `wait`")
            })
        })
    }
}

fn index_of(names: &[String], what: &str, name: &str) -> Result<usize, Failure> {
    names.iter().position(|known| known == name).ok_or_else(|| {
        let known: Vec<String> = names.iter().map(|known| format!("`{known}`")).collect();
        Failure::argument(format!("no {what} `{name}`; allowed is {}", known.join(", ")))
    })
}

/// Poses of hands in steps: end of the step (s), tool by number, place (m), rotation (x, y, z, w) and buttons of each.
type PoseArrays<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<u32>>,
);

fn pose_arrays<'py>(py: Python<'py>, used: &[UsedPose]) -> PoseArrays<'py> {
    let of = |used: &UsedPose| used.pose;
    (
        PyArray1::from_iter(py, used.iter().map(|used| used.time)),
        PyArray1::from_iter(py, used.iter().map(|used| used.tool as u32)),
        copy_rows::<_, 3>(py, used.iter().map(|used| of(used).position.into()), used.len()),
        copy_rows::<_, 4>(py, used.iter().map(|used| of(used).rotation.coords.into()), used.len()),
        PyArray1::from_iter(py, used.iter().map(|used| of(used).buttons)),
    )
}

/// Settings of a device from a dict with these keys (`GivenWish` of `_device_hand.py`); `None` keeps the present value.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(super) struct GivenWish {
    /// Point of the scene in the centre of the picture, m.
    pub(super) centre: Option<[f64; 3]>,
    /// From axes of the picture to those of the scene: a quaternion (x, y, z, w).
    pub(super) rotation: Option<[f64; 4]>,
    /// Buttons of the scene for none, the first and another of the device.
    pub(super) buttons: Option<[u32; 3]>,
    /// Share of the force, 0 to 1.
    pub(super) force_share: Option<f64>,
}

impl GivenWish {
    /// Changes what is asked, or nothing if a value is not allowed.
    pub(super) fn apply(&self, wish: &mut DeviceWish) -> Result<(), Failure> {
        let centre = self.centre.unwrap_or_else(|| wish.view.centre.into());
        let rotation = self.rotation.unwrap_or_else(|| wish.view.rotation.coords.into());
        let force_share = self.force_share.unwrap_or(wish.force_share);
        if !(0.0..=1.0).contains(&force_share) {
            return Err(Failure::argument(format!("force_share is {force_share}; allowed is 0 to 1")));
        }
        let pose = hand_pose(centre, rotation, 0)?;
        (wish.view.centre, wish.view.rotation) = (pose.position, pose.rotation);
        wish.buttons = self.buttons.unwrap_or(wish.buttons);
        wish.force_share = force_share;
        Ok(())
    }
}

/// The hand that a device has: vectors as tuples.
fn hand_dict<'py>(py: Python<'py>, hand: &LedHand) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let place = hand.state.place;
    dict.set_item("position", place.map(|place| <[f64; 3]>::from(place.position)))?;
    dict.set_item("rotation", place.map(|place| <[f64; 4]>::from(place.rotation.coords)))?;
    dict.set_item("buttons", hand.state.buttons)?;
    dict.set_item("force", <[f64; 3]>::from(hand.state.force))?;
    dict.set_item("force_limit", hand.state.force_limit)?;
    dict.set_item("length_scale", hand.length_scale)?;
    dict.set_item("strokes", hand.strokes)?;
    dict.set_item("in_stroke", hand.in_stroke)?;
    dict.set_item("lost", &hand.lost)?;
    Ok(dict)
}

#[pymethods]
impl Live {
    /// Sends the hand of a tool somewhere, or away.
    fn place_hand(&self, tool: &str, position: Option<[f64; 3]>, rotation: [f64; 4], buttons: u32) -> PyResult<()> {
        self.with(|thread| {
            let pose = position.map(|position| hand_pose(position, rotation, buttons)).transpose()?;
            thread.go(index_of(&self.tools, "tool", tool)?, pose)
        })
    }

    /// Changes what is asked of the device that has a hand.
    fn guide(&self, given: GivenWish) -> PyResult<()> {
        self.with(|thread| {
            let mut checked = Ok(());
            thread.guide(|asked| checked = given.apply(asked));
            checked
        })
    }

    /// The hand that a device has as a dict; empty before the first step.
    fn hand<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let hand = self.view(|view| Ok(view.hand.clone()))?;
        hand.as_ref().map_or_else(|| Ok(PyDict::new(py)), |hand| hand_dict(py, hand))
    }

    /// Takes the poses that steps have used since the last call.
    fn take_poses<'py>(&self, py: Python<'py>) -> PyResult<PoseArrays<'py>> {
        let used = self.with(|thread| Ok(thread.take_poses()))?;
        Ok(pose_arrays(py, &used))
    }

    /// Names of the tools, in the order that poses number them.
    #[getter]
    fn tools(&self) -> Vec<String> {
        self.tools.clone()
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

    /// Number of visible triangles of a body in the newest view, 0 before the first: another one says that the body was cut or broke.
    fn triangle_count(&self, body: &str) -> PyResult<usize> {
        let index = index_of(&self.bodies, "body", body)?;
        self.view(|view| Ok(view.triangles.get(index).copied().unwrap_or_default()))
    }

    /// Vertices that strokes have pinned, ascending, in the newest view.
    fn pinned<'py>(&self, py: Python<'py>, body: &str) -> PyResult<Bound<'py, PyArray1<u32>>> {
        Ok(self.painting(body)?.pinned_array(py))
    }

    /// Vertices whose parameter strokes have painted, ascending, and the factor of each, in the newest view.
    #[allow(clippy::type_complexity, reason = "two arrays")]
    fn painted<'py>(
        &self,
        py: Python<'py>,
        body: &str,
        param: &str,
    ) -> PyResult<(Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>)> {
        Ok(self.painting(body)?.painted_arrays(py, param)?)
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

    /// Ends the thread; the session goes on step by step. Gives the poses of hands that nobody has taken. With `keep_device` a device that has a hand stays open for
    /// another session, see [`Session::follow_on`].
    #[pyo3(signature = (keep_device=false))]
    fn stop<'py>(&self, py: Python<'py>, keep_device: bool) -> PyResult<PoseArrays<'py>> {
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(thread) = thread else { return Ok(pose_arrays(py, &[])) };
        if keep_device {
            thread.keep_device();
        }
        let ended = py.detach(|| thread.stop());
        let session = self.session.get();
        let (Ended { mut open, done, device }, used) = match ended {
            Ok(ended) => ended,
            Err(failure) => {
                session.end_live(None);
                return Err(failure.into());
            }
        };
        *self.kept.lock().unwrap_or_else(PoisonError::into_inner) = device;
        open.invalidate(py);
        session.end_live(done.is_ok().then_some(open));
        done?;
        Ok(pose_arrays(py, &used))
    }

    /// Closes a device that was kept, if there is one.
    fn close_kept(&self, py: Python<'_>) {
        let kept = self.take_kept();
        py.detach(|| drop(kept));
    }
}
