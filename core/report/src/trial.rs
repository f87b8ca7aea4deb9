//! One run of a scene, timed.

use super::clock::Clock;
use super::measure::{Measure, Reader};
use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{Choices, EventKind, Options, Session, SessionError};
use pliant_host::SearchPath;
use std::path::Path;

/// What is run.
pub struct Trial<'a> {
    /// What the scene is called; paths in it are relative to it.
    pub path: &'a Path,
    /// The scene.
    pub text: &'a str,
    /// Put in the place of what it says.
    pub set: Vec<(String, String)>,
    /// Threads.
    pub threads: usize,
    /// Where plugins are.
    pub search: &'a SearchPath,
    /// What time is.
    pub clock: Clock,
}

/// What it came to.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Of the measures, in order.
    pub values: Vec<f64>,
    /// s, of the steps
    pub wall: f64,
    /// s, of the steps, all threads
    pub cpu: f64,
    /// s, of opening
    pub open: f64,
    /// s, of each step
    pub steps: Vec<f64>,
    /// s, of each step: regions, contact, integration
    pub parts: Vec<[f64; 3]>,
    /// Bytes of the largest parts.
    pub bytes: u64,
    /// Nodes of the bodies at the end.
    pub nodes: usize,
    /// Of all solves.
    pub iterations: u64,
    /// The largest final residual.
    pub residual: f64,
    /// Solves that did not meet their tolerance.
    pub unconverged: u64,
    /// Why a body stands still, if one does.
    pub frozen: Option<String>,
    /// s
    pub dt: f64,
    /// What was chosen.
    pub choices: Choices,
    /// Plugins that were opened, with their versions.
    pub plugins: Vec<String>,
}

impl Trial<'_> {
    /// Opens the scene.
    ///
    /// # Errors
    /// What opening says.
    pub fn open(&self) -> Result<(scene::Scene, Session), SessionError> {
        let (scene, source) = scene::load_text(self.path, self.text.to_owned(), &self.set)?;
        let plan = Plan::new(&scene, &source)?;
        let options = Options { search: self.search.clone(), threads: self.threads, mesh: None, recorded: None };
        let session = Session::open(&scene, &source, plan, &options)?;
        Ok((scene, session))
    }

    /// Runs it to its end, or until `after`, called after every step, says stop.
    ///
    /// # Errors
    /// What opening says.
    pub fn run(
        &self,
        measures: &[&Measure],
        mut after: impl FnMut(&mut Session) -> bool,
    ) -> Result<Outcome, SessionError> {
        let began = ((self.clock.wall)(), (self.clock.cpu)());
        let (scene, mut session) = self.open()?;
        let mut readers: Vec<Reader> = measures.iter().map(|m| Reader::new(m, &session)).collect();
        let opened = ((self.clock.wall)(), (self.clock.cpu)());
        let steps = scene.time.steps();
        let (mut seconds, mut parts) = (Vec::with_capacity(steps as usize), Vec::new());
        let (mut iterations, mut residual) = (0, 0.0_f64);
        while session.steps() < steps {
            session.step();
            let frame = session.frame();
            seconds.push(frame.seconds);
            parts.push(frame.parts);
            iterations += frame.iterations as u64;
            residual = residual.max(frame.residual);
            readers.iter_mut().for_each(|r| r.step(&session));
            if !after(&mut session) {
                break;
            }
        }
        let ended = ((self.clock.wall)(), (self.clock.cpu)());
        let values = readers.iter().map(|r| r.value(&mut session)).collect();
        Ok(Outcome {
            values,
            wall: ended.0 - opened.0,
            cpu: ended.1 - opened.1,
            open: opened.0 - began.0,
            steps: seconds,
            parts,
            bytes: session.bytes() as u64,
            nodes: session.bodies.iter().map(|b| b.system.nodes.len()).sum(),
            iterations,
            residual,
            unconverged: session.events.count(EventKind::NotConverged),
            frozen: session.bodies.iter().find_map(|b| b.frozen.clone()),
            dt: session.dt(),
            choices: session.choices.clone(),
            plugins: session.loaded.iter().map(|l| format!("{} {}", l.id, l.version)).collect(),
        })
    }
}
