//! What is timed, as a text.

use crate::catalogue::{CatalogueError, NotRun, Settings};
use serde::Deserialize;
use std::collections::BTreeMap;

/// All of it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerformanceCatalogue {
    /// A scene at several sizes, contacts or settings.
    pub sweep: Vec<Sweep>,
    /// A scene against itself with something switched on that it does without.
    pub pair: Vec<Pair>,
    /// Scenes by the wall clock.
    #[serde(default)]
    pub haptic: Vec<Haptic>,
    /// What is not timed, and why.
    #[serde(default)]
    pub not_run: Vec<NotRun>,
}

/// A scene at several places.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Short, for rows.
    pub name: String,
    /// For people.
    pub title: String,
    /// Name of its scene.
    pub scene: String,
    /// Material, integrator, solver setting.
    pub method: String,
    /// By path, of all runs.
    #[serde(default)]
    pub set: Settings,
    /// From small to large.
    pub place: Vec<Place>,
    /// How many of them a quick report runs.
    pub quick: usize,
    /// Each place with so many.
    pub threads: Vec<usize>,
    /// The exponent with which a step should grow with the nodes, where size is swept.
    pub growth: Option<f64>,
}

/// One of a sweep.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Cells a side.
    pub n: u64,
    /// What else tells it from others, by name and unit.
    #[serde(default)]
    pub at: BTreeMap<String, f64>,
    /// By path.
    pub set: Settings,
}

/// A scene as it is, and with more.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pair {
    /// What is left out.
    pub name: String,
    /// Name of its scene.
    pub scene: String,
    /// By path, of both.
    #[serde(default)]
    pub set: Settings,
    /// By path, what switches it on.
    pub on: Settings,
}

/// A scene by the wall clock.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Haptic {
    /// For rows.
    pub name: String,
    /// Name of its scene.
    pub scene: String,
    /// Hz, of the haptic loop
    pub rate: f64,
    /// s, by which 99 % of its ticks must begin
    pub late: f64,
    /// By path.
    #[serde(default)]
    pub set: Settings,
}

impl PerformanceCatalogue {
    /// Reads a text.
    ///
    /// # Errors
    /// A text that is no catalogue.
    pub fn read(text: &str) -> Result<Self, CatalogueError> {
        Ok(toml::from_str(text)?)
    }
}
