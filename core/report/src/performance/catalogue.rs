//! Catalogues of timed cases. The keys of the file are older than some names of fields; `serde` keeps them.

use crate::catalogue::{CatalogueError, NotRun};
use crate::settings::Settings;
use serde::Deserialize;
use std::collections::BTreeMap;

/// All cases of a performance report.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerformanceCatalogue {
    /// Scenes at several sizes, contacts or settings.
    #[serde(rename = "sweep")]
    pub(super) sweeps: Vec<Sweep>,
    /// Scenes without and with a part that can be left out.
    #[serde(rename = "pair")]
    pub(super) pairs: Vec<LeftOutPair>,
    /// Scenes that run in real time.
    #[serde(default, rename = "haptic")]
    pub(super) haptic_loops: Vec<HapticLoop>,
    /// Cases that are not timed, and why.
    #[serde(default)]
    pub(super) not_run: Vec<NotRun>,
}

/// A scene at several sizes, contacts or settings.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sweep {
    /// Short name, for rows.
    pub(super) name: String,
    /// Title for people.
    pub(super) title: String,
    /// Name of its scene.
    pub(super) scene: String,
    /// Material, integrator and solver setting, in words.
    pub(super) method: String,
    /// Settings of all runs.
    #[serde(default, rename = "set")]
    pub(super) settings: Settings,
    /// Points from small to large.
    #[serde(rename = "place")]
    pub(super) points: Vec<SweepPoint>,
    /// Number of points that a quick report runs.
    #[serde(rename = "quick")]
    pub(super) quick_points: usize,
    /// Numbers of threads that each point is run with.
    pub(super) threads: Vec<usize>,
    /// Expected exponent of the time of a step over the number of nodes, where the size is swept.
    pub(super) growth: Option<f64>,
}

/// One point of a sweep.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SweepPoint {
    /// Cells a side.
    pub(super) n: u64,
    /// Other parameters that differ between points, by name and unit.
    #[serde(default, rename = "at")]
    pub(super) parameters: BTreeMap<String, f64>,
    /// Settings that make it.
    #[serde(rename = "set")]
    pub(super) settings: Settings,
}

/// A scene without and with a part that can be left out.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LeftOutPair {
    /// Name of the part.
    pub(super) name: String,
    /// Name of its scene.
    pub(super) scene: String,
    /// Settings of both runs.
    #[serde(default, rename = "set")]
    pub(super) settings: Settings,
    /// Settings that add the part.
    #[serde(rename = "on")]
    pub(super) with_part: Settings,
}

/// A scene that runs in real time.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HapticLoop {
    /// Name, for rows.
    pub(super) name: String,
    /// Name of its scene.
    pub(super) scene: String,
    /// Rate of the haptic loop, Hz.
    pub(super) rate: f64,
    /// Largest allowed 99th percentile of the lateness of its ticks, s.
    #[serde(rename = "late")]
    pub(super) allowed_lateness: f64,
    /// Settings of the run.
    #[serde(default, rename = "set")]
    pub(super) settings: Settings,
}

impl PerformanceCatalogue {
    /// Reads a catalogue.
    ///
    /// # Errors
    /// A text that is not a catalogue.
    pub fn parse(text: &str) -> Result<Self, CatalogueError> {
        Ok(toml::from_str(text)?)
    }

    /// Names of the cases, with `start-up` and `haptic-loop`, which every report has.
    pub fn case_names(&self) -> Vec<String> {
        let pairs = self.pairs.iter().map(|pair| pair.case());
        let sweeps = self.sweeps.iter().map(|sweep| sweep.name.clone());
        pairs.chain(sweeps).chain(["start-up".into(), "haptic-loop".into()]).collect()
    }
}

impl LeftOutPair {
    /// The case of both rows.
    pub(super) fn case(&self) -> String {
        format!("left-out: {}", self.name)
    }
}
