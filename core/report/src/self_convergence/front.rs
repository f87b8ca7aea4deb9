//! Runs that compute the same thing, and the one run that all of them are compared with.

use super::series::RefinementSeries;

/// Settings of a run, by their path in the scene.
pub(super) type Settings = Vec<(String, String)>;

/// Series whose runs compute the same thing. They share a reference and a Pareto front.
pub(super) struct Front {
    /// End of the name of its cases; empty for the scene's own grid.
    pub(super) name: &'static str,
    /// What its runs have in common, and why the reference is one, for people.
    pub(super) why: &'static str,
    /// Settings of the reference. Where the first does not open or converge, the next is taken.
    pub(super) references: Vec<Settings>,
    /// Time between two forces that are compared, s.
    pub(super) sample_period: f64,
    /// Series of the front, from coarse to fine.
    pub(super) series: Vec<RefinementSeries>,
}

/// Settings as people read them.
pub(super) fn describe(settings: &[(String, String)]) -> String {
    let all: Vec<String> = settings.iter().map(|(path, value)| format!("{path} = {value}")).collect();
    all.join(", ")
}
