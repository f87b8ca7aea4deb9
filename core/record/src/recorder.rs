//! Recording a run from its first step to its last file.

use crate::atomic::{AtomicFile, AtomicFolder, error_at, remove_leftovers};
use crate::force_plot::write_force_plot;
use crate::machine::Machine;
use crate::model::write_model;
use crate::probe::ProbeReader;
use crate::summary::{CutSummary, Durations, Summary, summarize_bodies};
use crate::trace::{write_header, write_nodes, write_row};
use pliant_engine::scene::{OutputScene, Scene, Source};
use pliant_engine::session::{DeviceSlot, EventKind, Session};
use pliant_live::{DeviceCounts, LiveSummary};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Records a run into a folder: trace and frames as it goes, the rest at its end.
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
    probes: ProbeReader,
    /// s, wall clock, of each step
    seconds: Vec<f64>,
    /// J, of each step in which the energy was positive and finite and no body was frozen
    energies: Vec<f64>,
    most_nodes: usize,
    most_elements: usize,
    contact_steps: u64,
    largest_force: f64,
    iterations: u64,
    largest_residual: f64,
    /// Number of the next frame.
    next_frame: u64,
    /// Timing and force safety of a live session, set by the caller before [`Recorder::finish`].
    pub live: Option<LiveSummary>,
}

/// Number of steps over which the growth of energy is measured.
const GROWTH_STEPS: usize = 100;

impl Recorder {
    /// Begins recording into `folder`. `began` is when opening the scene began.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn new(scene: &Scene, source: &Source, session: &Session, folder: &Path, began: Instant) -> io::Result<Self> {
        let summary = AtomicFile::create(&folder.join("summary.json"))?;
        remove_leftovers(folder);
        let frames = scene.output.frames.as_ref().map(|_| AtomicFolder::create(&folder.join("frames"))).transpose()?;
        let mut trace = None;
        if scene.output.trace {
            let mut file = AtomicFile::create(&folder.join("trace.csv"))?;
            write_header(session, &mut file)?;
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
            probes: ProbeReader::new(session),
            seconds: Vec::new(),
            energies: Vec::new(),
            most_nodes: 0,
            most_elements: 0,
            contact_steps: 0,
            largest_force: 0.0,
            iterations: 0,
            largest_residual: 0.0,
            next_frame: 0,
            live: None,
        })
    }

    /// Records the step the session has just taken. `last`: no step comes after it.
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
        self.most_nodes = self.most_nodes.max(frame.nodes);
        self.most_elements = self.most_elements.max(frame.elements);
        self.contact_steps += u64::from(frame.tools.iter().any(|t| t.contact.is_some()));
        self.iterations += frame.iterations as u64;
        self.largest_residual = self.largest_residual.max(frame.residual);
        for tool in &frame.tools {
            self.largest_force = self.largest_force.max(tool.force.norm());
        }
        // Number of frames due by now, with a margin for the rounding of the time.
        let due = self.output.frames.as_ref().map(|f| (frame.time * f.get_ref().si * (1.0 + 1e-9)) as u64);
        let writes_frame = due.is_some_and(|due| due >= self.next_frame);
        if writes_frame || last || self.probes.needs_surface(frame.time, last) {
            session.update_surface();
        }
        let frame = session.frame();
        self.probes.read(session, frame, last);
        if let Some(trace) = &mut self.trace {
            write_row(session.frame(), trace)?;
        }
        if let (true, Some(frames)) = (writes_frame, &self.frames) {
            let number = self.next_frame;
            self.write_models(session, frames.path(), &format!("-{number:05}"))?;
            self.next_frame = due.unwrap_or(number) + 1;
        }
        Ok(())
    }

    /// Gives every result its name and returns the summary, which is one of them. Results of an interrupted run go to `interrupted/` in
    /// the folder.
    ///
    /// # Errors
    /// A file that cannot be written; those already in place stay.
    pub fn finish(mut self, session: &mut Session, interrupted: bool) -> io::Result<Summary> {
        session.update_surface();
        // A run that was stopped must not replace the results of one that was finished.
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
            write_nodes(session, &mut file)?;
            file.finish()?;
        }
        if self.output.forces {
            let bodies = session.bodies.iter().enumerate().map(|(i, body)| (body, session.reactions(i)));
            write_force_plot(bodies, &folder.join("forces.svg"))?;
        }
        let summary = self.summary(session, interrupted);
        let path = folder.join("summary.json");
        serde_json::to_writer_pretty(&mut self.summary, &summary).map_err(|e| error_at(&path, e.into()))?;
        writeln!(self.summary)?;
        self.summary.finish_as(&path)?;
        Ok(summary)
    }

    /// Writes the model of every body: `final.obj`, or with several bodies `final-NAME.obj`; frames have a `number` in their names.
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

    /// Factor by which the energy grew in a step, over the last [`GROWTH_STEPS`]; `None` unless an integrator was forced.
    #[allow(
        clippy::disallowed_methods,
        reason = "a figure of the summary, which holds times and is not compared by bytes"
    )]
    fn growth(&self, session: &Session) -> Option<f64> {
        if session.events.count(EventKind::Unstable) == 0 {
            return None;
        }
        let span = GROWTH_STEPS.min(self.energies.len().checked_sub(1)?);
        let last = self.energies.last()?;
        (span > 0).then(|| (last / self.energies[self.energies.len() - 1 - span]).powf(1.0 / span as f64))
    }

    /// Everything the run came to; takes the live summary.
    fn summary(&mut self, session: &Session, interrupted: bool) -> Summary {
        let mut devices = device_counters(session);
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
            step_seconds: Durations::of(&mut self.seconds),
            cut: summarize_cuts(session),
            live: self.live.take(),
            loaded: session.loaded.clone(),
            left_out: session.left_out.clone(),
            bodies: summarize_bodies(session),
            most_nodes: self.most_nodes,
            most_elements: self.most_elements,
            contact_steps: self.contact_steps,
            largest_force: self.largest_force,
            iterations: self.iterations,
            largest_residual: self.largest_residual,
            growth: self.growth(session),
            probes: self.probes.results(),
            event_counts: session.events.counts().clone(),
            events: session.events.told().iter().map(|(_, e)| e.clone()).collect(),
            peak_memory: Machine::peak_memory(),
            machine: Machine::current(),
        }
    }
}

/// Cuts of a session; `None` if no blade changed a mesh.
fn summarize_cuts(session: &Session) -> Option<CutSummary> {
    let cuts = session.cuts();
    let seconds = Durations::of(&mut cuts.seconds.clone())?;
    Some(CutSummary { advances: cuts.advances, area: cuts.area, length: cuts.length, seconds })
}

/// Counters of the devices of a session by their names, those without counters left out.
fn device_counters(session: &Session) -> DeviceCounts {
    let counters = |slot: &DeviceSlot| {
        let counters = slot.counters();
        (!counters.is_empty()).then(|| (slot.name.clone(), counters.into_iter().collect()))
    };
    session.devices.iter().filter_map(counters).collect()
}
