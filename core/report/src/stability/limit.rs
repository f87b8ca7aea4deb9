//! The predicted step limit beside the observed one, which is found by bisection.

use super::map_run::MapRun;
use super::state::{RunState, run_and_classify};
use super::task::{Inputs, Task, is_explicit};
use crate::context::ReportContext;
use crate::row::Row;

/// Steps of a run: enough to detect a growth of 2 % per step from rounding errors.
const STEP_COUNT: u32 = 2000;
/// Allowed range of the ratio of the observed limit to the predicted one: below it the prediction is unsafe, above it wasteful.
const ALLOWED_RATIO: (f64, f64) = (0.999, 1.25);
/// Bisections of the interval from a quarter of the predicted limit to four times it: its ends are then 1 % apart.
const BISECTIONS: usize = 8;

/// A task for each explicit integrator at each point of the maps whose limit is searched for. A quick report has every third point.
pub(super) fn limit_tasks<'a>(inputs: Inputs<'a>, context: &ReportContext<'_>) -> Vec<Task<'a>> {
    let stride = if context.options.quick { 3 } else { 1 };
    let mut tasks = Vec::new();
    for map in inputs.catalogue.maps.iter().filter(|m| m.limit) {
        for integrator in map.integrators.iter().filter(|i| is_explicit(i)) {
            for point in map.points.iter().step_by(stride) {
                let (case, method) = (format!("limit-{}", map.name), integrator.clone());
                let mut row = Row { case, method, threads: context.options.threads, ..Row::default() };
                row.parameters.insert(map.parameter.clone(), point.value);
                let run = MapRun { inputs, map, point };
                tasks.push(Task::new(row, move |row, context| measure(run, row, context)));
            }
        }
    }
    tasks
}

/// Whether a run grew, and the step limit predicted for it (s).
struct Trial {
    grew: bool,
    predicted: Option<f64>,
}

/// Searches for the limit and compares it with the predicted one.
fn measure(run: MapRun<'_>, mut row: Row, context: &mut ReportContext<'_>) -> Row {
    let step_count = if context.options.quick { STEP_COUNT / 4 } else { STEP_COUNT };
    let mut try_step = |dt: f64| -> Option<Trial> {
        let classified = run_and_classify(&run.scene_run(&row.method, dt, step_count, context)?);
        let result = classified.result.ok()?;
        context.add_run(&result);
        row.wall_seconds += result.wall;
        row.cpu_seconds += result.cpu;
        Some(Trial { grew: classified.state == RunState::Growing, predicted: result.choices.step_limit })
    };
    // The prediction does not depend on the step that is tried.
    let Some(Trial { predicted: Some(predicted), .. }) = try_step(1e-9) else {
        return row.with_failure("no limit is predicted".into());
    };
    let (mut stable, mut growing) = (0.25 * predicted, 4.0 * predicted);
    let (lower, upper) = (try_step(stable), try_step(growing));
    if lower.is_none_or(|t| t.grew) || upper.is_none_or(|t| !t.grew) {
        return row
            .with_failure(format!("grows at a quarter of the limit, {stable:.3e} s, or does not at four times it"));
    }
    for _ in 0..BISECTIONS {
        let middle = (stable * growing).sqrt();
        match try_step(middle) {
            Some(Trial { grew: true, .. }) => growing = middle,
            _ => stable = middle,
        }
    }
    let observed = (stable * growing).sqrt();
    let ratio = observed / predicted;
    row.dt = predicted;
    row.results.extend([("predicted".into(), predicted), ("observed".into(), observed), ("ratio".into(), ratio)]);
    (row.error, row.tolerance) = (Some((ratio - 1.0).abs()), Some(ALLOWED_RATIO.1 - 1.0));
    row.passed = Some((ALLOWED_RATIO.0..=ALLOWED_RATIO.1).contains(&ratio));
    if ratio < ALLOWED_RATIO.0 {
        row.note = "it grows below the predicted limit".into();
    }
    row
}
