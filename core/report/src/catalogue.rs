//! Cases as texts: what is run, with which methods, at which resolutions, and what should come out.

use super::measure::Wanted;
use serde::Deserialize;
use std::collections::BTreeMap;
use thiserror::Error;

/// Values put in the place of a scene's, by path, as `--set` does.
pub type Settings = BTreeMap<String, toml::Value>;

/// All cases of a report.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Catalogue {
    /// In the order of the report.
    pub case: Vec<Case>,
    /// What is not run, and why.
    #[serde(default)]
    pub not_run: Vec<NotRun>,
}

/// A reference case that scenes cannot express.
#[derive(Clone, Debug, Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct NotRun {
    /// Which.
    pub case: String,
    /// Why, and what holds it instead.
    pub why: String,
}

/// Something with a known answer.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Short, for rows.
    pub name: String,
    /// For people.
    pub title: String,
    /// Name of its scene.
    pub scene: String,
    /// Where the answer comes from.
    pub source: String,
    /// What the error is, in words.
    pub norm: String,
    /// What the error may be at the resolution `at`.
    pub tolerance: f64,
    /// The resolution the tolerance is meant for: cells, or a step in seconds.
    pub at: f64,
    /// What is refined.
    pub over: Over,
    /// What is measured; the error is the largest of theirs.
    pub measure: Vec<Wanted>,
    /// Resolutions in space, coarse to fine.
    pub level: Vec<Level>,
    /// Steps, s, long to short.
    pub step: Vec<f64>,
    /// How many resolutions, from the coarsest, a quick report runs.
    #[serde(default = "three")]
    pub quick: usize,
    /// Below it errors are rounding, and have no order.
    #[serde(default = "floor")]
    pub floor: f64,
    /// What it is run with.
    pub method: Vec<Method>,
}

fn three() -> usize {
    3
}

fn floor() -> f64 {
    1e-10
}

/// What is refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Over {
    /// The mesh: errors go with the cell to the power of the order.
    N,
    /// The step.
    Dt,
}

/// A resolution.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Level {
    /// Cells along the case's edge.
    pub n: u64,
    /// What that means for the scene.
    #[serde(default)]
    pub set: Settings,
}

/// A way to run a case.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Method {
    /// Material, integrator, solver setting.
    pub name: String,
    /// What that means for the scene.
    #[serde(default)]
    pub set: Settings,
    /// The order theory gives it; absent where the result is exact or nothing is known.
    pub order: Option<f64>,
    /// In the place of the case's.
    pub tolerance: Option<f64>,
    /// In the place of the measures' own, one each.
    pub expected: Option<Vec<f64>>,
    /// Left out of quick reports.
    #[serde(default)]
    pub slow: bool,
}

/// A catalogue that cannot be read.
#[derive(Debug, Error)]
pub enum CatalogueError {
    /// Not what a catalogue is.
    #[error("catalogue: {0}")]
    Toml(#[from] toml::de::Error),
    /// A case that makes no sense.
    #[error("case `{case}`: {why}")]
    Case {
        /// Which.
        case: String,
        /// Why.
        why: String,
    },
}

impl Catalogue {
    /// Reads a text.
    ///
    /// # Errors
    /// A text that is no catalogue; a case without a level, a measure or a method, or with a wrong number of values.
    pub fn read(text: &str) -> Result<Self, CatalogueError> {
        let catalogue: Self = toml::from_str(text)?;
        for case in &catalogue.case {
            let wrong = |why: &str| Err(CatalogueError::Case { case: case.name.clone(), why: why.into() });
            if [case.level.len(), case.step.len(), case.measure.len(), case.method.len()].contains(&0) {
                return wrong("needs at least one level, one step, one measure and one method");
            }
            let wanted = case.measure.len();
            if case.method.iter().any(|m| m.expected.as_ref().is_some_and(|e| e.len() != wanted)) {
                return wrong("a method expects another number of values than are measured");
            }
        }
        Ok(catalogue)
    }
}

/// Settings as `--set` takes them.
pub(super) fn settings<'a>(all: impl IntoIterator<Item = &'a Settings>) -> Vec<(String, String)> {
    all.into_iter().flatten().map(|(path, value)| (path.clone(), value.to_string())).collect()
}
