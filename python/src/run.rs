//! A scene from its start to its end, as `pliant run` does it.

use super::ctrl_c::CtrlC;
use super::failure::{Failure, Kind, contained};
use super::law::check_signals;
use super::open::{OpenOptions, Opened, SceneText, open};
use super::open_session::Open;
use super::session::Session;
use super::trace::Trace;
use pliant_engine::session::CancelToken;
use pliant_record::{Recorder, RunStatistics, Summary};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How long steps are taken before Python is asked whether the user wants to stop.
const SIGNAL_PERIOD: Duration = Duration::from_millis(20);

/// Where results of a run go besides its trace.
enum Results {
    /// Into memory alone.
    Figures(Box<RunStatistics>),
    /// Into a folder too.
    Files(Box<Recorder>),
}

impl Results {
    fn step(&mut self, opened: &mut Opened, last: bool) -> Result<(), Failure> {
        match self {
            Self::Figures(figures) => figures.step(&mut opened.session, last, false),
            Self::Files(recorder) => recorder.step(&mut opened.session, last)?,
        }
        Ok(())
    }

    fn finish(self, opened: &mut Opened, interrupted: bool) -> Result<Summary, Failure> {
        match self {
            Self::Figures(mut figures) => {
                opened.session.update_surface();
                Ok(figures.summary(&opened.session, None, interrupted))
            }
            Self::Files(recorder) => Ok(recorder.finish(&mut opened.session, interrupted)?),
        }
    }
}

/// Runs a scene to its end. Gives the session as it is then, the trace as a dict of arrays, and the summary as JSON. With `out`, the
/// folder gets what `pliant run` writes; Ctrl-C puts what there is under `interrupted/` and raises `KeyboardInterrupt`.
#[pyfunction]
#[pyo3(signature = (scene, options, out=None))]
pub fn run<'py>(
    py: Python<'py>,
    scene: SceneText,
    options: OpenOptions,
    out: Option<PathBuf>,
) -> PyResult<(Session, Bound<'py, PyDict>, String)> {
    let began = Instant::now();
    let (mut opened, mut results, mut trace) = py.detach(|| {
        contained(|| {
            let opened = open(scene, &options)?;
            let results = match &out {
                None => Results::Figures(Box::new(RunStatistics::new(&opened.source, &opened.session, began))),
                Some(folder) => {
                    let recorder = Recorder::new(&opened.scene, &opened.source, &opened.session, folder, began)?;
                    Results::Files(Box::new(recorder))
                }
            };
            let trace = Trace::new(&opened.session, opened.scene.time.steps().min(1 << 20) as usize);
            Ok((opened, results, trace))
        })
    })?;
    let (opening, steps) = (began.elapsed(), opened.scene.time.steps());
    let ctrl_c = CtrlC::watch();
    opened.session.cancel_when(ctrl_c.token());
    let mut stopped = None;
    while opened.session.steps() < steps && stopped.is_none() {
        py.detach(|| {
            contained(|| {
                let began = Instant::now();
                while opened.session.steps() < steps && began.elapsed() < SIGNAL_PERIOD {
                    opened.session.step();
                    if opened.session.is_cancelled() {
                        break;
                    }
                    trace.step(opened.session.frame());
                    let last = opened.session.steps() == steps;
                    results.step(&mut opened, last)?;
                }
                Ok(())
            })
        })?;
        ctrl_c.clear();
        stopped = check_signals(py).err();
    }
    opened.session.cancel_when(CancelToken::default());
    let is_stopped = stopped.is_some();
    let summary = py.detach(|| contained(|| results.finish(&mut opened, is_stopped)))?;
    if let Some(stopped) = stopped {
        return Err(stopped);
    }
    let summary = serde_json::to_string(&summary).map_err(|error| Failure::new(Kind::Panic, error))?;
    let trace = trace.to_dict(py)?;
    Ok((Session::of(Open::new(opened, opening)), trace, summary))
}
