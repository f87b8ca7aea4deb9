//! One line of a report.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What one run, or one comparison of runs, came to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Which case.
    pub case: String,
    /// Material, integrator and solver setting, as far as they differ.
    pub method: String,
    /// Cells along the case's edge, or the level of a grid.
    pub n: u64,
    /// s
    pub dt: f64,
    /// Threads that worked.
    pub threads: usize,
    /// In the case's norm; absent where there is nothing to compare with or the run failed.
    pub error: Option<f64>,
    /// What the error may be at this resolution: the case's tolerance, grown by the expected order where this is coarser than
    /// the resolution the tolerance is meant for.
    pub tolerance: Option<f64>,
    /// Between this run and the one before it.
    pub order: Option<f64>,
    /// What theory says.
    pub expected_order: Option<f64>,
    /// Whether the error is within its tolerance and, of the finest run, the order not more than 0.3 below the expected one.
    pub passed: Option<bool>,
    /// s, of the steps
    pub wall_seconds: f64,
    /// s, of all threads
    pub cpu_seconds: f64,
    /// s, of opening the scene
    #[serde(default)]
    pub open_seconds: f64,
    /// s
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_seconds_median: Option<f64>,
    /// s
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_seconds_p99: Option<f64>,
    /// Quarter points of the repeats' medians: their distance over the median.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<f64>,
    /// Bytes of the largest parts.
    #[serde(default)]
    pub bytes: u64,
    /// Of all solves.
    #[serde(default)]
    pub iterations: u64,
    /// Nothing is both faster and more exact in its case.
    #[serde(default)]
    pub front: bool,
    /// What happened, of stability: `stable`, `damped`, `growing`, `refused`, `not converged`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub state: String,
    /// What was varied besides, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub at: BTreeMap<String, f64>,
    /// What was found besides, by name; SI.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub found: BTreeMap<String, f64>,
    /// For people.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

impl Row {
    /// What tells it from the other rows of a report: all that was set, nothing that was found.
    pub fn key(&self) -> String {
        let at: Vec<String> = self.at.iter().map(|(name, value)| format!("{name}={value:e}")).collect();
        format!("{}|{}|{}|{:e}|{}|{}", self.case, self.method, self.n, self.dt, self.threads, at.join(","))
    }

    /// Whether it missed what it had to meet.
    pub fn missed(&self) -> bool {
        self.passed == Some(false)
    }
}
