//! The summary of a run: one machine-readable document, `summary.json`.

use crate::inputs::InputHash;
use crate::machine::Machine;
use crate::probe::ProbeResult;
use pliant_engine::plan::LeftOut;
use pliant_engine::session::{Choices, Event, EventKind, Loaded, Session, Warning};
use pliant_live::{DeviceCounts, Histogram, LiveSummary, Percentiles};
use pliant_mesh::check::Kind;
use serde::Serialize;
use std::collections::BTreeMap;

/// Statistics of durations, s.
#[derive(Clone, Debug, Serialize)]
pub struct Durations {
    /// Shortest duration, s.
    pub min: f64,
    /// Median of the durations, s.
    pub p50: f64,
    /// 99th percentile, s.
    pub p99: f64,
    /// Longest duration, s.
    pub max: f64,
}

impl Durations {
    /// Statistics of a list, s, which is sorted; `None` for an empty list.
    pub fn of(seconds: &mut [f64]) -> Option<Self> {
        seconds.sort_by(f64::total_cmp);
        let at = |share: f64| seconds.get(((seconds.len() as f64 * share) as usize).min(seconds.len().max(1) - 1));
        Some(Self { min: *at(0.0)?, p50: *at(0.5)?, p99: *at(0.99)?, max: *at(1.0)? })
    }
}

/// Statistics of any number of durations in fixed memory. Median and 99th percentile have an error of at most 0.2 %.
#[derive(Clone, Debug)]
pub(crate) struct DurationStatistics {
    /// Numbers of durations by length.
    histogram: Histogram,
    /// Shortest duration, s.
    shortest: f64,
    /// Longest duration, s.
    longest: f64,
}

impl Default for DurationStatistics {
    fn default() -> Self {
        Self { histogram: Histogram::default(), shortest: f64::INFINITY, longest: 0.0 }
    }
}

impl DurationStatistics {
    /// Adds a duration, s.
    pub(crate) fn add(&mut self, seconds: f64) {
        self.histogram.add((seconds * 1e9) as u64);
        self.shortest = self.shortest.min(seconds);
        self.longest = self.longest.max(seconds);
    }

    /// Statistics of the durations so far; `None` if there are none.
    pub(crate) fn durations(&self) -> Option<Durations> {
        let Percentiles { p50, p99, .. } = self.histogram.percentiles()?;
        let [p50, p99] = [p50, p99].map(|s| s.clamp(self.shortest, self.longest));
        Some(Durations { min: self.shortest, p50, p99, max: self.longest })
    }
}

/// Cuts of a run.
#[derive(Clone, Debug, Serialize)]
pub struct CutSummary {
    /// Number of advances of a blade that changed a mesh.
    pub advances: usize,
    /// Area of the cuts inside of closed bodies, one side of two, m^2.
    pub area: f64,
    /// Length of the cuts through sheets, one side of two, m.
    pub length: f64,
    /// Wall-clock time of the advances: mesh, model, lattice and samples.
    pub seconds: Durations,
}

/// One body of a session.
#[derive(Clone, Debug, Serialize)]
pub struct BodySummary {
    /// Name in the scene.
    pub name: String,
    /// File of the model, or the kind of generated shape.
    pub model: String,
    /// Number of vertices of the model.
    pub vertices: usize,
    /// Number of triangles of the model.
    pub triangles: usize,
    /// Level of the grid, if the body has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<u32>,
    /// Number of tetrahedra of the file, if the model is a tetrahedral mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tetrahedra: Option<usize>,
    /// Number of nodes of each of these tetrahedra: 4, or 10 for quadratic ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes_of_tetrahedron: Option<u32>,
    /// Edge length of a cell, or mean edge length of the triangles of a sheet or of the tetrahedra of a file, m; with quadratic
    /// tetrahedra that of their eight parts.
    pub edge: f64,
    /// Number of occupied cells of the level, if the body has a grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<u64>,
    /// Number of edges with a single triangle; 0 for a closed model.
    pub border_edges: usize,
    /// Number of vertices of borders that `weld` has joined to others.
    pub welded_vertices: usize,
    /// Why the body was frozen, if it was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frozen: Option<String>,
}

/// Results of a run in numbers.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Program and version that made the run.
    pub program: String,
    /// Path of the scene; invalid UTF-8 is replaced.
    pub scene: String,
    /// Content of the scene, `--set` included.
    pub settings: toml::Table,
    /// Whether the run was stopped before its end.
    pub interrupted: bool,
    /// Simulated time, s.
    pub simulated_seconds: f64,
    /// Wall-clock time from opening to the last file, s.
    pub wall_seconds: f64,
    /// Wall-clock time of opening the scene, s.
    pub open_seconds: f64,
    /// Step of the simulation, s.
    pub dt: f64,
    /// Number of steps taken.
    pub steps: u64,
    /// Integrator, step limits, substeps and threads, and why they were chosen.
    pub choices: Choices,
    /// Wall-clock time of the steps; `None` if none was taken.
    pub step_seconds: Option<Durations>,
    /// Timing and force safety of a live run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub live: Option<LiveSummary>,
    /// Cuts, if a blade changed a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut: Option<CutSummary>,
    /// Plugins that were opened.
    pub loaded: Vec<Loaded>,
    /// Parts that the scene does not need, and why.
    pub left_out: Vec<LeftOut>,
    /// Counters of the devices, by name; devices without counters are left out.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub devices: DeviceCounts,
    /// The simulated bodies.
    pub bodies: Vec<BodySummary>,
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
    /// Mean growth factor of the energy in a step, over the last hundred steps; of an explicit integrator that exceeds its step limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growth: Option<f64>,
    /// Results of the probes.
    pub probes: Vec<ProbeResult>,
    /// Number of events of each kind.
    pub event_counts: BTreeMap<EventKind, u64>,
    /// The first events of each kind, in full.
    pub events: Vec<Event>,
    /// Settings without the expected effect, by code.
    pub warnings: Vec<Warning>,
    /// Peak resident memory, bytes; `None` if the system does not report it.
    pub peak_memory: Option<u64>,
    /// The machine of the run.
    pub machine: Machine,
    /// Program, scene, models and plugins with their digests, of a run that writes files.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<InputHash>,
    /// The other files of this set of results, relative to its folder.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

impl Summary {
    /// Whether every probe with an expected value met it, and no body was frozen in a run that exceeds its step limit.
    pub fn passed(&self) -> bool {
        self.probes.iter().all(|p| p.passed != Some(false)) && !(self.forced() && self.quarantined())
    }

    /// Whether an explicit integrator exceeded its step limit.
    fn forced(&self) -> bool {
        self.event_counts.contains_key(&EventKind::Unstable)
    }

    /// Whether a body was frozen because its material or state failed.
    fn quarantined(&self) -> bool {
        self.event_counts.contains_key(&EventKind::Quarantine)
    }

    /// Whether a plugin or device failed during the run.
    pub fn plugin_failed(&self) -> bool {
        self.event_counts.contains_key(&EventKind::DeviceLost) || (self.quarantined() && !self.forced())
    }
}

/// Number of border edges of the model of a body, before any cut.
fn border_edges(body: &pliant_engine::body::Body) -> usize {
    body.model.findings.iter().find(|finding| finding.kind == Kind::Border).map_or(0, |finding| finding.count)
}

/// The lattice of a body that is embedded in a grid.
fn grid(body: &pliant_engine::body::Body) -> Option<&pliant_engine::body::Lattice> {
    body.discretization.lattice().filter(|lattice| lattice.source.plugin().is_some())
}

/// Summaries of the simulated bodies of a session.
pub fn summarize_bodies(session: &Session) -> Vec<BodySummary> {
    let summary = |body: &pliant_engine::body::Body| BodySummary {
        name: body.name.clone(),
        model: body.model.document.name().display().to_string(),
        vertices: body.model.surface.points.len(),
        triangles: body.model.surface.triangles.len(),
        level: grid(body).map(|lattice| lattice.settings.level),
        tetrahedra: body.model.tetrahedra.as_ref().map(|cells| cells.mesh().elements()),
        nodes_of_tetrahedron: body.model.tetrahedra.as_ref().map(
            |cells| {
                if cells.corner_weights().is_some() { 10 } else { 4 }
            },
        ),
        edge: body.discretization.edge(),
        cells: grid(body).map(|lattice| lattice.facts.surface_cells + lattice.facts.inside_cells),
        border_edges: border_edges(body),
        welded_vertices: body.model.document.welds().len(),
        frozen: body.frozen.clone(),
    };
    session.bodies.iter().map(summary).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_as_they_come_are_those_of_the_sorted_list() {
        let mut list: Vec<f64> =
            (0..20_000_u64).map(|i| 1e-9 * ((i * i * 2_654_435_761) % 3_000_017 + 50) as f64).collect();
        let mut streamed = DurationStatistics::default();
        assert!(streamed.durations().is_none());
        list.iter().for_each(|s| streamed.add(*s));
        let (streamed, exact) = (streamed.durations().unwrap(), Durations::of(&mut list).unwrap());
        assert_eq!((streamed.min, streamed.max), (exact.min, exact.max));
        for (s, e) in [(streamed.p50, exact.p50), (streamed.p99, exact.p99)] {
            assert!((s / e - 1.0).abs() < 2.5e-3, "{s} {e}");
        }
    }
}
