//! What a run came to, in one machine-readable document.

use super::machine::Machine;
use super::probe::ProbeResult;
use pliant_engine::plan::LeftOut;
use pliant_engine::session::{Choices, Event, EventKind, Loaded, Session};
use pliant_live::{DeviceCounts, LiveSummary};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Seconds of the steps taken.
#[derive(Clone, Debug, Serialize)]
pub struct StepSeconds {
    /// s
    pub min: f64,
    /// s, the median
    pub p50: f64,
    /// s
    pub p99: f64,
    /// s
    pub max: f64,
}

impl StepSeconds {
    /// Of a list in any order; `None` of an empty one.
    pub fn of(seconds: &mut [f64]) -> Option<Self> {
        seconds.sort_by(f64::total_cmp);
        let at = |share: f64| seconds.get(((seconds.len() as f64 * share) as usize).min(seconds.len().max(1) - 1));
        Some(Self { min: *at(0.0)?, p50: *at(0.5)?, p99: *at(0.99)?, max: *at(1.0)? })
    }
}

/// What blades did.
#[derive(Clone, Debug, Serialize)]
pub struct CutSummary {
    /// Advances that changed a mesh.
    pub advances: usize,
    /// m^2, of new cut surface inside of closed bodies, one wall of two
    pub area: f64,
    /// m, of new edge, one side of two
    pub length: f64,
    /// Seconds of the advances: mesh, model, lattice and samples
    pub seconds: StepSeconds,
}

/// One body.
#[derive(Clone, Debug, Serialize)]
pub struct BodySummary {
    /// As the scene calls it.
    pub name: String,
    /// File of the model, or the kind of shape.
    pub model: String,
    /// Vertices of the model.
    pub vertices: usize,
    /// Triangles of the model.
    pub triangles: usize,
    /// Level of the grid, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<u32>,
    /// m, edge of a cell; of a sheet, the mean edge of its triangles
    pub edge: f64,
    /// Occupied cells of the level, if there is a grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<u64>,
    /// Why it stands still, if it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frozen: Option<String>,
}

/// What a run came to.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The program that made it.
    pub program: String,
    /// The scene's file.
    pub scene: PathBuf,
    /// What it says, `--set` included.
    pub settings: toml::Table,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
    /// s
    pub simulated_seconds: f64,
    /// s, wall clock, from opening to the last file
    pub wall_seconds: f64,
    /// s, wall clock, of opening
    pub open_seconds: f64,
    /// s
    pub dt: f64,
    /// Steps taken.
    pub steps: u64,
    /// What was chosen.
    pub choices: Choices,
    /// Seconds of the steps.
    pub step_seconds: Option<StepSeconds>,
    /// How it kept its time and its limits, if it was live.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub live: Option<LiveSummary>,
    /// What blades did, if they did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut: Option<CutSummary>,
    /// Files that were opened.
    pub loaded: Vec<Loaded>,
    /// What was left out, and why.
    pub left_out: Vec<LeftOut>,
    /// What devices counted, by their names; those that count nothing are not here.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub devices: DeviceCounts,
    /// Bodies that moved.
    pub bodies: Vec<BodySummary>,
    /// The most nodes and elements that were active at once.
    pub most_nodes: usize,
    /// See `most_nodes`.
    pub most_elements: usize,
    /// Steps with a tool in contact.
    pub contact_steps: u64,
    /// N, the largest force on a hand
    pub largest_force: f64,
    /// Iterations of all solves.
    pub iterations: u64,
    /// The largest final relative residual of a solve.
    pub largest_residual: f64,
    /// Energy of the last step over that of the step a hundred before, per step; of a scheme forced over its limit
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growth: Option<f64>,
    /// What was measured.
    pub probes: Vec<ProbeResult>,
    /// How often things happened.
    pub event_counts: BTreeMap<EventKind, u64>,
    /// The first few of each, in full.
    pub events: Vec<Event>,
    /// Bytes
    pub peak_memory: Option<u64>,
    /// Where it was measured.
    pub machine: Machine,
}

impl Summary {
    /// Whether every probe that expects something got it, and nothing blew up that was forced to run over its limit.
    pub fn passed(&self) -> bool {
        self.probes.iter().all(|p| p.passed != Some(false)) && !(self.forced() && self.quarantined())
    }

    fn forced(&self) -> bool {
        self.event_counts.contains_key(&EventKind::Unstable)
    }

    fn quarantined(&self) -> bool {
        self.event_counts.contains_key(&EventKind::Quarantine)
    }

    /// Whether a plugin or device failed on the way.
    pub fn plugin_failed(&self) -> bool {
        self.event_counts.contains_key(&EventKind::DeviceLost) || (self.quarantined() && !self.forced())
    }
}

/// The bodies of a session.
pub fn bodies(session: &Session) -> Vec<BodySummary> {
    let summary = |body: &pliant_engine::body::Body| BodySummary {
        name: body.name.clone(),
        model: body.model.document.name().display().to_string(),
        vertices: body.model.surface.points.len(),
        triangles: body.model.surface.triangles.len(),
        level: body.carrier.lattice().map(|lattice| lattice.settings.level),
        edge: body.carrier.edge(),
        cells: body.carrier.lattice().map(|lattice| lattice.facts.surface_cells + lattice.facts.inside_cells),
        frozen: body.frozen.clone(),
    };
    session.bodies.iter().map(summary).collect()
}
