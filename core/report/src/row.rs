//! One row of a report.

use crate::scene_run::RunResult;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Result of one run, or of one comparison of runs. Keys in files differ from names of fields where `serde` renames them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the case.
    pub case: String,
    /// Material, integrator and solver setting, as far as they differ between the rows of a case.
    pub method: String,
    /// Cells along the case's edge, or the level of a grid.
    pub n: u64,
    /// Step of the simulation, s.
    pub dt: f64,
    /// Threads of the run.
    pub threads: usize,
    /// Error in the case's norm; absent if there is no reference or the run failed.
    pub error: Option<f64>,
    /// Settings of the run that the error is relative to; empty where the answer is known.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reference: String,
    /// Largest allowed error at this resolution: the case's tolerance, scaled by the expected order if the run is coarser than the resolution of the tolerance.
    pub tolerance: Option<f64>,
    /// Order of convergence between the run before this one and this one.
    pub order: Option<f64>,
    /// Theoretical order of convergence.
    pub expected_order: Option<f64>,
    /// Whether the row meets its criterion; absent without a criterion.
    pub passed: Option<bool>,
    /// Wall-clock time of the steps, s.
    pub wall_seconds: f64,
    /// Processor time of all threads, s.
    pub cpu_seconds: f64,
    /// Wall-clock time of opening the scene, s.
    #[serde(default)]
    pub open_seconds: f64,
    /// Median time of a step after the warm-up, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_seconds_median: Option<f64>,
    /// 99th percentile of the time of a step after the warm-up, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_seconds_p99: Option<f64>,
    /// Range of the repeats' medians over their median.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<f64>,
    /// Bytes of the largest data structures of the session.
    #[serde(default)]
    pub bytes: u64,
    /// Iterations of all linear solves.
    #[serde(default)]
    pub iterations: u64,
    /// Whether the row is on the Pareto front of its case: no other is both faster and more accurate.
    #[serde(default, rename = "front")]
    pub on_front: bool,
    /// State of a stability run: `stable`, `damped`, `growing`, `refused` or `not converged`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub state: String,
    /// Other parameters that were varied, by name and unit.
    #[serde(default, rename = "at", skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
    /// Other results, by name and unit.
    #[serde(default, rename = "found", skip_serializing_if = "BTreeMap::is_empty")]
    pub results: BTreeMap<String, f64>,
    /// Remarks for people, separated by `; `.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

impl Row {
    /// Key of the row in a report: all settings and no measurements.
    pub fn key(&self) -> String {
        let parameters: Vec<String> = self.parameters.iter().map(|(name, value)| format!("{name}={value:e}")).collect();
        format!("{}|{}|{}|{:e}|{}|{}", self.case, self.method, self.n, self.dt, self.threads, parameters.join(","))
    }

    /// Whether the row failed its criterion.
    pub fn failed(&self) -> bool {
        self.passed == Some(false)
    }

    /// Copies times, memory and iterations of a run.
    pub(crate) fn set_cost(&mut self, result: &RunResult) {
        (self.wall_seconds, self.cpu_seconds, self.open_seconds) = (result.wall, result.cpu, result.open);
        (self.bytes, self.iterations) = (result.bytes, result.iterations);
    }

    /// Adds a remark to the note.
    pub(crate) fn add_note(&mut self, remark: &str) {
        if !self.note.is_empty() {
            self.note += "; ";
        }
        self.note += remark;
    }

    /// The row of a run that could not be executed: it fails its criterion, and `reason` is its note.
    pub(crate) fn with_failure(self, reason: String) -> Self {
        Self { passed: Some(false), note: reason, ..self }
    }
}
