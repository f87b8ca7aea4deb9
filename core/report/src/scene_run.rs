//! One timed run of a scene.

use crate::clock::Clock;
use crate::measure::{Measure, MeasureReader};
use crate::settings::Setting;
use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{CancelToken, Choices, EventKind, Options, Session, SessionError};
use pliant_host::SearchPath;
use std::path::Path;

/// Returns the text of a scene by name; `None` if there is no such scene.
pub type SceneSource<'a> = &'a dyn Fn(&str) -> Option<&'a str>;

/// A scene to run, with its settings.
pub(crate) struct SceneRun<'a> {
    /// File of the scene; paths in it are relative to its folder.
    pub(crate) path: &'a Path,
    /// Text of the scene.
    pub(crate) text: &'a str,
    /// Values that replace those of the scene.
    pub(crate) settings: Vec<Setting>,
    pub(crate) threads: usize,
    /// Folders in which plugins are searched for.
    pub(crate) search: &'a SearchPath,
    /// Clocks of the run.
    pub(crate) clock: Clock,
    /// Ends the step under way, and the run.
    pub(crate) stop: CancelToken,
}

/// Measurements of one run.
#[derive(Clone, Debug)]
pub(crate) struct RunResult {
    /// Values of the measures in their order, SI; NaN if there is nothing to measure.
    pub(crate) values: Vec<f64>,
    /// Wall-clock time of all steps, s.
    pub(crate) wall: f64,
    /// Processor time of all threads during the steps, s.
    pub(crate) cpu: f64,
    /// Wall-clock time of opening the scene, s.
    pub(crate) open: f64,
    /// Wall-clock time of each step, s.
    pub(crate) step_seconds: Vec<f64>,
    /// Time of each step in regions, contact and integration, s.
    pub(crate) stage_seconds: Vec<[f64; 3]>,
    /// Bytes of the largest data structures of the session.
    pub(crate) bytes: u64,
    /// Nodes of all bodies at the end.
    pub(crate) nodes: usize,
    /// Iterations of all linear solves.
    pub(crate) iterations: u64,
    /// Largest final relative residual of a solve.
    pub(crate) residual: f64,
    /// Number of solves that did not meet their tolerance.
    pub(crate) unconverged: u64,
    /// Reason why a body was frozen; `None` if none was.
    pub(crate) frozen: Option<String>,
    /// Step of the simulation, s.
    pub(crate) dt: f64,
    /// Integrator, step limit, substeps and threads that were chosen.
    pub(crate) choices: Choices,
    /// Plugins that were opened, with their versions.
    pub(crate) plugins: Vec<String>,
}

impl SceneRun<'_> {
    /// Opens the scene.
    ///
    /// # Errors
    /// Returns an error if the scene cannot be read, planned or opened.
    pub(crate) fn open(&self) -> Result<(scene::Scene, Session), SessionError> {
        let (scene, source) = scene::load_text(self.path, self.text.to_owned(), &self.settings)?;
        let plan = Plan::new(&scene, &source)?;
        let options = Options::new(self.search.clone(), self.threads);
        let mut session = Session::open(&scene, &source, plan, &options)?;
        session.cancel_when(self.stop.clone());
        Ok((scene, session))
    }

    /// Runs the scene to its end, or until `after_step` returns false.
    ///
    /// # Errors
    /// Those of [`SceneRun::open`].
    pub(crate) fn run(
        &self,
        measures: &[&Measure],
        mut after_step: impl FnMut(&mut Session) -> bool,
    ) -> Result<RunResult, SessionError> {
        let began = (self.clock.wall)();
        let (scene, mut session) = self.open()?;
        let mut readers: Vec<MeasureReader> = measures.iter().map(|m| MeasureReader::new(m, &session)).collect();
        let (opened, opened_cpu) = ((self.clock.wall)(), (self.clock.cpu)());
        let steps = scene.time.steps();
        let (mut step_seconds, mut stage_seconds) = (Vec::with_capacity(steps as usize), Vec::new());
        let (mut iterations, mut residual) = (0, 0.0_f64);
        while session.steps() < steps {
            session.step();
            if session.is_cancelled() {
                break;
            }
            let frame = session.frame();
            step_seconds.push(frame.seconds);
            stage_seconds.push(frame.parts);
            iterations += frame.iterations as u64;
            residual = residual.max(frame.residual);
            readers.iter_mut().for_each(|r| r.step(&session));
            if !after_step(&mut session) {
                break;
            }
        }
        let (ended, ended_cpu) = ((self.clock.wall)(), (self.clock.cpu)());
        let values = readers.iter().map(|r| r.value(&mut session)).collect();
        Ok(RunResult {
            values,
            wall: ended - opened,
            cpu: ended_cpu - opened_cpu,
            open: opened - began,
            step_seconds,
            stage_seconds,
            bytes: session.bytes() as u64,
            nodes: session.bodies.iter().map(|b| b.system.nodes.len()).sum(),
            iterations,
            residual,
            unconverged: session.events.count(EventKind::NotConverged),
            frozen: session.bodies.iter().find_map(|b| b.frozen.clone()),
            dt: session.dt(),
            choices: session.choices.clone(),
            plugins: session.inputs.loaded.iter().map(|l| format!("{} {}", l.id, l.version)).collect(),
        })
    }
}
