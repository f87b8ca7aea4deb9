//! Common parts of stability reports.

use super::catalogue::StabilityCatalogue;
use crate::context::ReportContext;
use crate::row::Row;
use crate::scene_run::{SceneRun, SceneSource};
use crate::settings::Setting;
use pliant_solver::Scheme;
use std::path::Path;

/// Inputs of a stability report.
#[derive(Clone, Copy)]
pub(super) struct Inputs<'a> {
    pub(super) catalogue: &'a StabilityCatalogue,
    pub(super) scenes: SceneSource<'a>,
    /// Folder of the generated meshes.
    pub(super) mesh_folder: &'a Path,
}

/// One row to measure.
pub(super) struct Task<'a> {
    /// The row with all settings and no measurements.
    pub(super) row: Row,
    /// Fills the row in.
    pub(super) measure: Measurement<'a>,
}

/// Fills in the measurements of a row.
type Measurement<'a> = Box<dyn Fn(Row, &mut ReportContext<'_>) -> Row + 'a>;

impl<'a> Task<'a> {
    /// A row and how it is measured.
    pub(super) fn new(row: Row, measure: impl Fn(Row, &mut ReportContext<'_>) -> Row + 'a) -> Self {
        Self { row, measure: Box::new(measure) }
    }
}

/// A run of the scene `name` with settings; `None` where there is no such scene.
pub(super) fn scene_run<'r, 'a: 'r>(
    scenes: SceneSource<'a>,
    name: &'r str,
    settings: Vec<Setting>,
    context: &'r ReportContext<'_>,
) -> Option<SceneRun<'r>> {
    let text = scenes(name)?;
    let (threads, search, clock) = (context.options.threads, &context.options.search, context.options.clock);
    Some(SceneRun { path: Path::new(name), text, settings, threads, search, clock, stop: context.stop() })
}

/// Whether the integrator with this name in scene files is explicit: it has a step limit.
pub(super) fn is_explicit(integrator: &str) -> bool {
    Scheme::from_name(integrator).is_some_and(|scheme| !scheme.is_implicit())
}
