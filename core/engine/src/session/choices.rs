//! Choices that a session makes where a scene leaves them open, for plans and summaries.

use super::level_choice::LevelChosen;
use serde::Serialize;

/// Choices made when the session was opened.
#[derive(Clone, Debug, Serialize)]
pub struct Choices {
    /// Name of the time integration scheme.
    pub integrator: &'static str,
    /// Reason for the choice; empty if the scene gives it.
    pub why: String,
    /// Largest stable step, s; `None` without a limit.
    pub step_limit: Option<f64>,
    /// Largest stable step by Gershgorin's rigorous bound, s; `None` without a limit.
    pub certain_step_limit: Option<f64>,
    /// Number of substeps in a step.
    pub substeps: usize,
    /// Number of threads.
    pub threads: usize,
    /// Contact methods of tools on sheets.
    pub contacts: Vec<ContactChoice>,
    /// Levels of grids that `level = "auto"` chose.
    pub levels: Vec<LevelChosen>,
    /// How often the faces of bodies with `subdivide` were divided.
    pub subdivisions: Vec<LevelChosen>,
    /// Preconditioner of each body; empty for explicit schemes.
    pub preconditioners: Vec<PreconditionerChosen>,
}

/// Contact method of a tool on a sheet.
#[derive(Clone, Debug, Serialize)]
pub struct ContactChoice {
    /// Name of the tool.
    pub tool: String,
    /// Name of the body, a sheet.
    pub body: String,
    /// Name of the method in scene files.
    pub by: &'static str,
    /// Id of the contact law, for a tool that has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    /// Reason for the choice; empty if the scene gives it.
    pub why: String,
}

/// Preconditioner of a body.
#[derive(Clone, Debug, Serialize)]
pub struct PreconditionerChosen {
    /// Name of the body in the scene.
    pub body: String,
    /// Name of the preconditioner.
    pub preconditioner: &'static str,
    /// Reason for the choice.
    pub why: String,
}
