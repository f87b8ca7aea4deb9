//! Catalogues of stability cases. The keys of the file are older than some names of fields; `serde` keeps them.

use crate::catalogue::{CatalogueError, NotRun};
use crate::settings::Settings;
use serde::Deserialize;

/// All cases of a stability report.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StabilityCatalogue {
    /// Maps of states over the step and another parameter.
    #[serde(rename = "map")]
    pub(super) maps: Vec<StabilityMap>,
    /// Runs whose energy or momentum is balanced.
    #[serde(rename = "balance")]
    pub(super) balances: Vec<ConservationCase>,
    /// Values at the ends of what is allowed, and beyond.
    #[serde(rename = "extreme")]
    pub(super) extremes: Vec<ExtremeCase>,
    /// Cases that are not run, and why.
    #[serde(default)]
    pub(super) not_run: Vec<NotRun>,
}

/// A map of states over the step and another parameter.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StabilityMap {
    /// Short name, for rows.
    pub(super) name: String,
    /// Title for people.
    pub(super) title: String,
    /// Name of its scene.
    pub(super) scene: String,
    /// Name and unit of the parameter.
    #[serde(rename = "along")]
    pub(super) parameter: String,
    /// Values of the parameter, ascending.
    #[serde(rename = "point")]
    pub(super) points: Vec<MapPoint>,
    /// Steps (s), ascending.
    #[serde(rename = "step")]
    pub(super) step_sizes: Vec<f64>,
    /// Number of steps of a run.
    #[serde(rename = "steps")]
    pub(super) step_count: u32,
    /// Names of the integrators, as a scene gives them.
    #[serde(rename = "integrator")]
    pub(super) integrators: Vec<String>,
    /// Whether the mesh of the scene is generated: rows of triangles alternate between two heights whose ratio is the parameter.
    #[serde(default)]
    pub(super) graded: bool,
    /// Whether the step limit of explicit integrators is searched for.
    #[serde(default)]
    pub(super) limit: bool,
}

/// A value of a map's parameter.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MapPoint {
    /// Value in the unit of the parameter.
    pub(super) value: f64,
    /// Settings that make it.
    #[serde(rename = "set")]
    pub(super) settings: Settings,
}

/// A run whose energy or momentum is balanced.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ConservationCase {
    /// Short name, for rows.
    pub(super) name: String,
    /// Title for people.
    pub(super) title: String,
    /// Name of its scene.
    pub(super) scene: String,
    /// What is balanced.
    #[serde(rename = "of")]
    pub(super) quantity: ConservedQuantity,
    /// Largest allowed excess of energy over the work done, or change of the momentum over its magnitude.
    pub(super) tolerance: f64,
    /// Time after which no external force acts on the bodies, s, for the check of a momentum.
    #[serde(default)]
    pub(super) after: f64,
    /// Names of the integrators, as a scene gives them.
    #[serde(rename = "integrator")]
    pub(super) integrators: Vec<String>,
    /// Settings of all runs.
    #[serde(default, rename = "set")]
    pub(super) settings: Settings,
}

/// What is balanced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ConservedQuantity {
    /// Energy, J: no more may be held than the work done.
    Energy,
    /// Linear momentum, kg m/s: it stays once nothing acts.
    Momentum,
    /// Angular momentum about the origin, kg m^2/s: it stays once nothing acts.
    AngularMomentum,
}

/// A value at the end of what is allowed, or beyond.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExtremeCase {
    /// Name, for rows and people.
    pub(super) name: String,
    /// Name of its scene.
    pub(super) scene: String,
    /// Settings that make it.
    #[serde(rename = "set")]
    pub(super) settings: Settings,
    /// Required state: a name of [`RunState`](super::state::RunState), or `bounded` for any but growing and refused.
    pub(super) expect: String,
    /// Text that a refusal must contain.
    #[serde(default)]
    pub(super) says: String,
}

impl StabilityCatalogue {
    /// Reads a catalogue.
    ///
    /// # Errors
    /// A text that is not a catalogue.
    pub fn parse(text: &str) -> Result<Self, CatalogueError> {
        Ok(toml::from_str(text)?)
    }

    /// Names of the cases, with `extreme` and `coupling`, which every report has.
    pub fn case_names(&self) -> Vec<String> {
        let maps = self.maps.iter().flat_map(|map| [map.name.clone(), format!("limit-{}", map.name)]);
        let balances = self.balances.iter().map(|case| case.name.clone());
        maps.chain(balances).chain(["extreme".into(), "coupling".into()]).collect()
    }
}
