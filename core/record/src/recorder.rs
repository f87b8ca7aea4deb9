//! Following a run from its first step to its last file.

use super::atomic::{AtomicFile, AtomicFolder, with_path};
use super::forces::write_forces;
use super::machine::Machine;
use super::model::write_model;
use super::probe::Meter;
use super::summary::{CutSummary, StepSeconds, Summary, bodies};
use super::trace;
use pliant_engine::scene::{OutputScene, Scene, Source};
use pliant_engine::session::{EventKind, Session};
use pliant_live::{DeviceCounts, LiveSummary};
use pliant_solver::dot;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Records a run into a folder.
pub struct Recorder {
    folder: PathBuf,
    scene: PathBuf,
    settings: toml::Table,
    output: OutputScene,
    began: Instant,
    open_seconds: f64,
    trace: Option<AtomicFile>,
    frames: Option<AtomicFolder>,
    /// Begun first, so that a folder that cannot be written to is found before the run.
    summary: AtomicFile,
    meter: Meter,
    seconds: Vec<f64>,
    energies: Vec<f64>,
    most: (usize, usize),
    contact_steps: u64,
    largest_force: f64,
    iterations: u64,
    largest_residual: f64,
    pictures: u64,
    /// How a live session kept its time.
    pub live: Option<LiveSummary>,
}

/// Steps over which growth is measured.
const GROWTH_STEPS: usize = 100;

impl Recorder {
    /// Begins. `began` is when opening the scene began.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn new(scene: &Scene, source: &Source, session: &Session, folder: &Path, began: Instant) -> io::Result<Self> {
        let summary = AtomicFile::create(&folder.join("summary.json"))?;
        let frames = scene.output.frames.as_ref().map(|_| AtomicFolder::create(&folder.join("frames"))).transpose()?;
        let mut trace = None;
        if scene.output.trace {
            let mut file = AtomicFile::create(&folder.join("trace.csv"))?;
            trace::head(session, &mut file)?;
            trace = Some(file);
        }
        Ok(Self {
            folder: folder.to_path_buf(),
            scene: source.path.clone(),
            settings: source.text.parse().unwrap_or_default(),
            output: scene.output.clone(),
            began,
            open_seconds: began.elapsed().as_secs_f64(),
            trace,
            frames,
            summary,
            meter: Meter::new(session),
            seconds: Vec::new(),
            energies: Vec::new(),
            most: (0, 0),
            contact_steps: 0,
            largest_force: 0.0,
            iterations: 0,
            largest_residual: 0.0,
            pictures: 0,
            live: None,
        })
    }

    /// Takes in the last step. `last`: no other comes after it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn step(&mut self, session: &mut Session, last: bool) -> io::Result<()> {
        let frame = session.frame();
        self.seconds.push(frame.seconds);
        let energy = frame.kinetic_energy + frame.elastic_energy;
        if energy > 0.0 && energy.is_finite() && session.bodies.iter().all(|b| b.frozen.is_none()) {
            self.energies.push(energy);
        }
        self.most = (self.most.0.max(frame.nodes), self.most.1.max(frame.elements));
        self.contact_steps += u64::from(frame.tools.iter().any(|t| t.contact.is_some()));
        self.iterations += frame.iterations as u64;
        self.largest_residual = self.largest_residual.max(frame.residual);
        for tool in &frame.tools {
            self.largest_force = self.largest_force.max(dot(tool.force, tool.force).sqrt());
        }
        let due = self.output.frames.as_ref().map(|f| (frame.time * f.get_ref().si * (1.0 + 1e-9)) as u64);
        let picture = due.is_some_and(|due| due >= self.pictures);
        if picture || last || self.meter.needs_surface(frame.time, last) {
            session.update_surface();
        }
        let frame = session.frame();
        self.meter.read(session, frame, last);
        if let Some(trace) = &mut self.trace {
            trace::row(session.frame(), trace)?;
        }
        if let (true, Some(frames)) = (picture, &self.frames) {
            let number = self.pictures;
            self.write_models(session, frames.path(), &format!("-{number:05}"))?;
            self.pictures = due.unwrap_or(number) + 1;
        }
        Ok(())
    }

    /// Puts every result in its place and gives the summary, which is one of them.
    ///
    /// # Errors
    /// A file that cannot be written; those already in place stay.
    pub fn finish(mut self, session: &mut Session, interrupted: bool) -> io::Result<Summary> {
        session.update_surface();
        // What was stopped half-way must not take the place of what was finished before.
        let folder = if interrupted { self.folder.join("interrupted") } else { self.folder.clone() };
        self.write_models(session, &folder, "")?;
        if let Some(trace) = self.trace.take() {
            trace.finish_as(&folder.join("trace.csv"))?;
        }
        if let Some(frames) = self.frames.take() {
            frames.finish_as(&folder.join("frames"))?;
        }
        if self.output.nodes {
            let mut file = AtomicFile::create(&folder.join("nodes.csv"))?;
            trace::nodes(session, &mut file)?;
            file.finish()?;
        }
        if self.output.forces {
            let bodies = session.bodies.iter().enumerate().map(|(i, body)| (body, session.reactions(i)));
            write_forces(bodies, &folder.join("forces.svg"))?;
        }
        let summary = self.summary(session, interrupted);
        let path = folder.join("summary.json");
        serde_json::to_writer_pretty(&mut self.summary, &summary).map_err(|e| with_path(&path, e.into()))?;
        writeln!(self.summary)?;
        self.summary.finish_as(&path)?;
        Ok(summary)
    }

    /// `final.obj`, or with several bodies `final-NAME.obj`.
    fn write_models(&self, session: &Session, folder: &Path, number: &str) -> io::Result<()> {
        let alone = session.bodies.len() + session.standing.len() == 1;
        let file = |name: &str| {
            let name = if alone { String::new() } else { format!("-{name}") };
            folder.join(if number.is_empty() { format!("final{name}.obj") } else { format!("frame{name}{number}.obj") })
        };
        for body in &session.bodies {
            write_model(body, &session.plan().cap_material, &file(&body.name))?;
        }
        for (name, model) in session.standing.iter().filter(|_| number.is_empty()) {
            let mut out = AtomicFile::create(&file(name))?;
            out.write_all(model.document.bytes())?;
            out.finish()?;
        }
        Ok(())
    }

    fn growth(&self, session: &Session) -> Option<f64> {
        if session.events.count(EventKind::Unstable) == 0 {
            return None;
        }
        let span = GROWTH_STEPS.min(self.energies.len().checked_sub(1)?);
        let last = self.energies.last()?;
        (span > 0).then(|| (last / self.energies[self.energies.len() - 1 - span]).powf(1.0 / span as f64))
    }

    fn summary(&mut self, session: &Session, interrupted: bool) -> Summary {
        let mut devices = counted(session);
        if let Some(live) = &mut self.live {
            devices.append(&mut live.devices);
        }
        Summary {
            devices,
            program: format!("pliant {}", env!("CARGO_PKG_VERSION")),
            scene: self.scene.clone(),
            settings: self.settings.clone(),
            interrupted,
            simulated_seconds: session.time(),
            wall_seconds: self.began.elapsed().as_secs_f64(),
            open_seconds: self.open_seconds,
            dt: session.dt(),
            steps: session.steps(),
            choices: session.choices.clone(),
            step_seconds: StepSeconds::of(&mut self.seconds),
            cut: cut(session),
            live: self.live.take(),
            loaded: session.loaded.clone(),
            left_out: session.left_out.clone(),
            bodies: bodies(session),
            most_nodes: self.most.0,
            most_elements: self.most.1,
            contact_steps: self.contact_steps,
            largest_force: self.largest_force,
            iterations: self.iterations,
            largest_residual: self.largest_residual,
            growth: self.growth(session),
            probes: self.meter.results(),
            event_counts: session.events.counts().clone(),
            events: session.events.told().iter().map(|(_, e)| e.clone()).collect(),
            peak_memory: Machine::peak_memory(),
            machine: Machine::here(),
        }
    }
}

fn cut(session: &Session) -> Option<CutSummary> {
    let cuts = session.cuts();
    let seconds = StepSeconds::of(&mut cuts.seconds.clone())?;
    Some(CutSummary { advances: cuts.advances, area: cuts.area, length: cuts.length, seconds })
}

/// What the devices of a session have counted.
fn counted(session: &Session) -> DeviceCounts {
    let of = |slot: &pliant_engine::session::DeviceSlot| {
        let counters = slot.counters();
        (!counters.is_empty()).then(|| (slot.name.clone(), counters.into_iter().collect()))
    };
    session.devices.iter().filter_map(of).collect()
}
