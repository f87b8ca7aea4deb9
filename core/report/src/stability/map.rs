//! Maps of states over the step and another parameter, by integrator. Explicit integrators are forced beyond their limit, so that the map shows the actual
//! behaviour; the predicted step limit, beyond which the program refuses scenes, is drawn into it.

use super::catalogue::StabilityMap;
use super::map_run::MapRun;
use super::state::{ClassifiedRun, RunState, run_and_classify};
use super::task::{Inputs, Task};
use crate::context::ReportContext;
use crate::row::Row;

/// A task for every point of every map. A quick report has every second value of both parameters.
pub(super) fn map_tasks<'a>(inputs: Inputs<'a>, context: &ReportContext<'_>) -> Vec<Task<'a>> {
    let stride = if context.options.quick { 2 } else { 1 };
    let mut tasks = Vec::new();
    for map in &inputs.catalogue.maps {
        for integrator in &map.integrators {
            for point in map.points.iter().step_by(stride) {
                let run = MapRun { inputs, map, point };
                for dt in map.step_sizes.iter().step_by(stride) {
                    let row = empty_row(map, integrator, point.value, *dt, context.options.threads);
                    tasks.push(Task::new(row, move |row, context| measure(run, row, context)));
                }
            }
        }
    }
    tasks
}

/// The row with all settings and no measurements.
fn empty_row(map: &StabilityMap, integrator: &str, value: f64, dt: f64, threads: usize) -> Row {
    let (case, method) = (map.name.clone(), integrator.to_owned());
    let mut row = Row { case, method, dt, threads, ..Row::default() };
    row.parameters.insert(map.parameter.clone(), value);
    row
}

/// Runs the scene and fills in its state. A run within the predicted limit must not grow.
fn measure(run: MapRun<'_>, mut row: Row, context: &mut ReportContext<'_>) -> Row {
    let Some(scene_run) = run.scene_run(&row.method, row.dt, run.map.step_count, context) else {
        row.note = format!("no scene `{}`", run.map.scene);
        return row;
    };
    let ClassifiedRun { state, balance, result } = run_and_classify(&scene_run);
    row.state = state.name().into();
    row.results.insert("energy from nothing (share)".into(), balance.excess().min(1e300));
    match result {
        Ok(result) => {
            (row.wall_seconds, row.cpu_seconds, row.iterations) = (result.wall, result.cpu, result.iterations);
            row.passed = result.choices.step_limit.map(|limit| row.dt > limit || state != RunState::Growing);
            row.results.extend(result.choices.step_limit.map(|limit| ("predicted".into(), limit)));
            context.add_run(&result);
        }
        Err(error) => row.note = error.to_string(),
    }
    row
}
