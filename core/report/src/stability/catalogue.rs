//! What stability is asked of, as a text.

use crate::catalogue::{CatalogueError, NotRun, Settings};
use serde::Deserialize;

/// All of it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StabilityCatalogue {
    /// Maps over a step and one other thing.
    pub map: Vec<Map>,
    /// Runs whose energy or momentum is accounted for.
    pub balance: Vec<Balance>,
    /// Values at the ends of what is allowed, and beyond.
    pub extreme: Vec<Extreme>,
    /// What is not run, and why.
    #[serde(default)]
    pub not_run: Vec<NotRun>,
}

/// A map.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Map {
    /// Short, for rows.
    pub name: String,
    /// For people.
    pub title: String,
    /// Name of its scene.
    pub scene: String,
    /// Name and unit of what is varied.
    pub along: String,
    /// Its values, rising.
    pub point: Vec<Point>,
    /// s, rising
    pub step: Vec<f64>,
    /// Steps of a run.
    pub steps: u32,
    /// Which.
    pub integrator: Vec<String>,
    /// Whether the scene's mesh is made here: rows high and low in turn, whose heights have the point's value as their ratio.
    #[serde(default)]
    pub graded: bool,
    /// Whether the step limit is looked for, of explicit integrators.
    #[serde(default)]
    pub limit: bool,
}

/// A value, and what it means for the scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// SI
    pub value: f64,
    /// By path.
    pub set: Settings,
}

/// A run that is accounted for.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Balance {
    /// Short, for rows.
    pub name: String,
    /// For people.
    pub title: String,
    /// Name of its scene.
    pub scene: String,
    /// `energy`: none may come from nothing; `momentum`: it stays once nothing acts.
    pub of: Account,
    /// Share of the energy, or of the momentum.
    pub tolerance: f64,
    /// s, from when nothing acts, of momentum
    #[serde(default)]
    pub after: f64,
    /// Which.
    pub integrator: Vec<String>,
    /// By path.
    #[serde(default)]
    pub set: Settings,
}

/// What is accounted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Account {
    /// J
    Energy,
    /// kg m/s
    Momentum,
    /// kg m^2/s
    AngularMomentum,
}

/// A value at the end of what is allowed, or beyond.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Extreme {
    /// For rows and people.
    pub name: String,
    /// Name of its scene.
    pub scene: String,
    /// By path.
    pub set: Settings,
    /// What must happen: a word of [`State`](super::State), or `bounded`: any but growing.
    pub expect: String,
    /// Of a refusal, what it must say.
    #[serde(default)]
    pub says: String,
}

impl StabilityCatalogue {
    /// Reads a text.
    ///
    /// # Errors
    /// A text that is no catalogue.
    pub fn read(text: &str) -> Result<Self, CatalogueError> {
        Ok(toml::from_str(text)?)
    }
}
