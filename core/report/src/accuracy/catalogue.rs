//! Catalogues of cases with known answers: scenes, methods, resolutions and expected values. Keys of the file differ from names of fields where `serde` renames
//! them.

use crate::catalogue::{CatalogueError, NotRun};
use crate::measure::ExpectedMeasure;
use crate::settings::Settings;
use serde::Deserialize;

/// All cases of an accuracy report.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AccuracyCatalogue {
    /// Cases in the order of the report.
    #[serde(rename = "case")]
    pub(super) cases: Vec<AccuracyCase>,
    /// Cases that are not run, and why.
    #[serde(default)]
    pub(super) not_run: Vec<NotRun>,
}

/// A case with a known answer.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AccuracyCase {
    /// Short name, for rows.
    pub(super) name: String,
    /// Title for people.
    pub(super) title: String,
    /// Name of its scene.
    pub(super) scene: String,
    /// Source of the expected values.
    pub(super) source: String,
    /// Description of the error.
    pub(super) norm: String,
    /// Largest allowed error at the resolution `tolerance_at`.
    pub(super) tolerance: f64,
    /// Resolution for which the tolerance holds: cells along the edge, or a step (s).
    #[serde(rename = "at")]
    pub(super) tolerance_at: f64,
    /// The refined quantity.
    #[serde(rename = "over")]
    pub(super) refinement: Refinement,
    /// Measured quantities. The error of a run is the largest error among them.
    #[serde(rename = "measure")]
    pub(super) measures: Vec<ExpectedMeasure>,
    /// Resolutions in space, coarse to fine.
    #[serde(rename = "level")]
    pub(super) levels: Vec<Level>,
    /// Steps (s), long to short.
    #[serde(rename = "step")]
    pub(super) steps: Vec<f64>,
    /// Number of resolutions, from the coarsest, that a quick report runs.
    #[serde(default = "default_quick", rename = "quick")]
    pub(super) quick_resolutions: usize,
    /// Errors below this are rounding and have no order.
    #[serde(default = "default_floor")]
    pub(super) floor: f64,
    /// Methods the case is run with.
    #[serde(rename = "method")]
    pub(super) methods: Vec<Method>,
}

/// Three resolutions are the fewest that show two orders.
fn default_quick() -> usize {
    3
}

/// Relative rounding of sums over a mesh in double precision.
fn default_floor() -> f64 {
    1e-10
}

/// The quantity that is refined between the runs of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub(super) enum Refinement {
    /// The mesh: errors are proportional to a power of the cell size.
    #[serde(rename = "n")]
    Space,
    /// The step: errors are proportional to a power of the step.
    #[serde(rename = "dt")]
    Time,
}

/// A resolution in space.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Level {
    /// Cells along the case's edge.
    pub(super) n: u64,
    /// Settings that make it.
    #[serde(default, rename = "set")]
    pub(super) settings: Settings,
}

/// A material, integrator and solver setting that a case is run with.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Method {
    /// Name, for rows.
    pub(super) name: String,
    /// Settings that make it.
    #[serde(default, rename = "set")]
    pub(super) settings: Settings,
    /// Order of convergence in theory; absent where the result is exact or the order is not known.
    pub(super) order: Option<f64>,
    /// Tolerance that takes the place of the case's.
    pub(super) tolerance: Option<f64>,
    /// Expected values that take the place of the measures' own, one for each.
    pub(super) expected: Option<Vec<f64>>,
    /// Whether the method is left out of quick reports.
    #[serde(default)]
    pub(super) slow: bool,
}

impl AccuracyCatalogue {
    /// Reads a catalogue.
    ///
    /// # Errors
    /// Returns an error if the text is not a catalogue, or if a case has no level, step, measure or method, or a wrong number of expected values.
    pub fn parse(text: &str) -> Result<Self, CatalogueError> {
        let catalogue: Self = toml::from_str(text)?;
        for case in &catalogue.cases {
            let wrong = |why: String| Err(CatalogueError::Case { case: case.name.clone(), why });
            if [case.levels.len(), case.steps.len(), case.measures.len(), case.methods.len()].contains(&0) {
                return wrong("allowed is at least one level, one step, one measure and one method".into());
            }
            let wanted = case.measures.len();
            let given = |method: &Method| method.expected.as_ref().map_or(wanted, Vec::len);
            if let Some(method) = case.methods.iter().find(|m| given(m) != wanted) {
                let (name, given) = (&method.name, given(method));
                return wrong(format!(
                    "method `{name}` expects {given} values; allowed is {wanted}, one for each measure"
                ));
            }
        }
        Ok(catalogue)
    }

    /// Names of the cases.
    pub fn case_names(&self) -> Vec<String> {
        self.cases.iter().map(|case| case.name.clone()).collect()
    }
}
