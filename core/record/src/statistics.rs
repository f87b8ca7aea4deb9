//! Figures of a run, updated in each step: probes, durations, extremes; and the summary made of them.

use crate::inputs::shown;
use crate::machine::Machine;
use crate::probe::{ProbeReader, ProbeResult};
use crate::summary::{CutSummary, DurationStatistics, Durations, Summary, summarize_bodies};
use pliant_engine::scene::Source;
use pliant_engine::session::{DeviceSlot, EventKind, Session};
use pliant_live::{DeviceCounts, LiveSummary};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::Instant;

/// Figures of a run.
pub struct RunStatistics {
    /// Path of the scene.
    scene: PathBuf,
    /// Text of the scene; parsed for the summary.
    settings: String,
    /// Time at which opening the scene began.
    began: Instant,
    /// Wall-clock time of opening the scene, s.
    open_seconds: f64,
    /// Values of the probes so far.
    probes: ProbeReader,
    /// Wall-clock times of the steps.
    seconds: DurationStatistics,
    /// Energies of the last [`GROWTH_STEPS`] + 1 steps in which the energy was positive and finite and no body was frozen, J.
    energies: VecDeque<f64>,
    /// Largest number of nodes active at once.
    pub most_nodes: usize,
    /// Largest number of elements active at once.
    pub most_elements: usize,
    /// Number of steps with a tool in contact.
    pub contact_steps: u64,
    /// Largest force on a hand before force safety, N.
    pub largest_force: f64,
    /// Iterations of all linear solves.
    pub iterations: u64,
    /// Largest final relative residual of a solve.
    pub largest_residual: f64,
}

/// Number of steps over which the growth of energy is measured.
const GROWTH_STEPS: usize = 100;

impl RunStatistics {
    /// Figures of a session that was just opened from `source`. `began` is the time at which opening began.
    pub fn new(source: &Source, session: &Session, began: Instant) -> Self {
        Self {
            scene: source.path.clone(),
            settings: source.text.to_string(),
            began,
            open_seconds: began.elapsed().as_secs_f64(),
            probes: ProbeReader::new(session),
            seconds: DurationStatistics::default(),
            energies: VecDeque::with_capacity(GROWTH_STEPS + 2),
            most_nodes: 0,
            most_elements: 0,
            contact_steps: 0,
            largest_force: 0.0,
            iterations: 0,
            largest_residual: 0.0,
        }
    }

    /// Adds the last step of the session. `last`: no step comes after it. The surface is updated if a probe or `needs_surface` asks for it.
    pub fn step(&mut self, session: &mut Session, last: bool, needs_surface: bool) {
        let frame = session.frame();
        self.seconds.add(frame.seconds);
        let energy = frame.kinetic_energy + frame.elastic_energy;
        if energy > 0.0 && energy.is_finite() && session.bodies.iter().all(|b| b.frozen.is_none()) {
            self.energies.push_back(energy);
            if self.energies.len() > GROWTH_STEPS + 1 {
                self.energies.pop_front();
            }
        }
        self.most_nodes = self.most_nodes.max(frame.nodes);
        self.most_elements = self.most_elements.max(frame.elements);
        self.contact_steps += u64::from(frame.tools.iter().any(|t| t.contact.is_some()));
        self.iterations += frame.iterations as u64;
        self.largest_residual = self.largest_residual.max(frame.residual);
        for tool in &frame.tools {
            self.largest_force = self.largest_force.max(tool.force.norm());
        }
        if needs_surface || self.probes.needs_surface(frame.time, last) {
            session.update_surface();
        }
        self.probes.read(session, session.frame(), last);
    }

    /// Results of the probes so far, in the order of the scene.
    pub fn probes(&self) -> Vec<ProbeResult> {
        self.probes.results()
    }

    /// Mean growth factor of the energy in a step, over the last [`GROWTH_STEPS`]; `None` unless an integrator exceeded its step limit.
    #[allow(
        clippy::disallowed_methods,
        reason = "a figure of the summary, which holds times and is not compared by bytes"
    )]
    fn growth(&self, session: &Session) -> Option<f64> {
        if session.events.count(EventKind::Unstable) == 0 {
            return None;
        }
        let span = GROWTH_STEPS.min(self.energies.len().checked_sub(1)?);
        let last = self.energies.back()?;
        (span > 0).then(|| (last / self.energies[self.energies.len() - 1 - span]).powf(1.0 / span as f64))
    }

    /// The summary. `live` has timing and force safety of a live session.
    pub fn summary(&mut self, session: &Session, mut live: Option<LiveSummary>, interrupted: bool) -> Summary {
        let mut devices = device_counters(session);
        if let Some(live) = &mut live {
            devices.append(&mut live.devices);
        }
        Summary {
            devices,
            program: format!("pliant {}", env!("CARGO_PKG_VERSION")),
            scene: shown(&self.scene),
            settings: self.settings.parse().unwrap_or_default(),
            interrupted,
            simulated_seconds: session.time(),
            wall_seconds: self.began.elapsed().as_secs_f64(),
            open_seconds: self.open_seconds,
            dt: session.dt(),
            steps: session.steps(),
            choices: session.choices.clone(),
            step_seconds: self.seconds.durations(),
            cut: summarize_cuts(session),
            live,
            loaded: session.inputs.loaded.clone(),
            left_out: session.plan().left_out.clone(),
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
            events: session.events.described().iter().map(|(_, e)| e.clone()).collect(),
            warnings: session.warnings(),
            peak_memory: Machine::peak_memory(),
            machine: Machine::current(),
            inputs: Vec::new(),
            files: Vec::new(),
        }
    }
}

/// Cuts of a session; `None` if no blade changed a mesh.
fn summarize_cuts(session: &Session) -> Option<CutSummary> {
    let cuts = session.cuts();
    let seconds = Durations::of(&mut cuts.seconds.clone())?;
    Some(CutSummary { advances: cuts.advances, area: cuts.area, length: cuts.length, seconds })
}

/// Counters of the devices of a session, by name; devices without counters are left out.
fn device_counters(session: &Session) -> DeviceCounts {
    let counters = |slot: &DeviceSlot| {
        let counters = slot.counters();
        (!counters.is_empty()).then(|| (slot.name.clone(), counters.into_iter().collect()))
    };
    session.devices.iter().filter_map(counters).collect()
}
