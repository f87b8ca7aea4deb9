//! Runs a stability catalogue.

use super::catalogue::StabilityCatalogue;
use super::conservation::conservation_tasks;
use super::coupling::coupling_tasks;
use super::extreme::extreme_tasks;
use super::graded_mesh::write_graded_meshes;
use super::limit::limit_tasks;
use super::map::map_tasks;
use super::page::stability_sections;
use super::task::{Inputs, Task};
use crate::context::ReportContext;
use crate::document::Measurements;
use crate::journal::Journal;
use crate::scene_run::SceneSource;
use std::path::Path;

/// Runs every wanted case of a catalogue. Meshes that are generated for it are written into `mesh_folder`.
///
/// # Errors
/// A mesh that cannot be written.
pub fn stability<'a>(
    catalogue: &'a StabilityCatalogue,
    scenes: SceneSource<'a>,
    mesh_folder: &'a Path,
    context: &mut ReportContext<'_>,
    journal: &mut Journal,
) -> std::io::Result<Measurements> {
    write_graded_meshes(catalogue, mesh_folder)?;
    let inputs = Inputs { catalogue, scenes, mesh_folder };
    let mut tasks: Vec<Task<'a>> = map_tasks(inputs, context);
    tasks.extend(limit_tasks(inputs, context));
    tasks.extend(conservation_tasks(inputs, context));
    tasks.extend(extreme_tasks(inputs, context));
    tasks.extend(coupling_tasks(context));
    tasks.retain(|task| context.wants(&task.row.case));
    let (total, mut rows) = (tasks.len(), Vec::with_capacity(tasks.len()));
    for (done, Task { row, measure }) in tasks.into_iter().enumerate() {
        if context.is_stopped() {
            break;
        }
        context.announce(done, total, &format!("{}, {}", row.case, row.method));
        let known = journal.get(&row.key());
        let is_known = known.is_some();
        let row = known.unwrap_or_else(|| measure(row, context));
        if context.is_stopped() {
            break;
        }
        if !is_known {
            journal.put(&row);
        }
        rows.push(row);
    }
    let sections = stability_sections(catalogue, &rows);
    Ok(Measurements { rows, sections, not_run: catalogue.not_run.clone() })
}
