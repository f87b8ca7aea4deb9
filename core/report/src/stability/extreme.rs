//! Runs with settings at and beyond the limits of their allowed ranges: the state of each is compared with the required one.

use super::catalogue::ExtremeCase;
use super::state::{ClassifiedRun, RunState, run_and_classify};
use super::task::{Inputs, Task, scene_run};
use crate::context::ReportContext;
use crate::row::Row;
use crate::settings::merge;

/// A task for each case.
pub(super) fn extreme_tasks<'a>(inputs: Inputs<'a>, context: &ReportContext<'_>) -> Vec<Task<'a>> {
    let threads = context.options.threads;
    let task = |case: &'a ExtremeCase| {
        let row = Row { case: "extreme".to_owned(), method: case.name.clone(), threads, ..Row::default() };
        Task::new(row, move |row, context| measure(case, inputs, row, context))
    };
    inputs.catalogue.extremes.iter().map(task).collect()
}

/// Runs the scene and compares its state with the required one.
fn measure(case: &ExtremeCase, inputs: Inputs<'_>, mut row: Row, context: &mut ReportContext<'_>) -> Row {
    let Some(run) = scene_run(inputs.scenes, &case.scene, merge([&case.settings]), context) else {
        return row.with_failure(format!("no scene `{}`", case.scene));
    };
    let ClassifiedRun { state, balance, result } = run_and_classify(&run);
    row.state = state.name().into();
    let said = match result {
        Ok(result) => {
            row.dt = result.dt;
            (row.wall_seconds, row.cpu_seconds, row.iterations) = (result.wall, result.cpu, result.iterations);
            row.results.insert("energy from nothing (share)".into(), balance.excess().min(1e300));
            row.results.insert("residual".into(), result.residual);
            let mut said = result.frozen.clone().unwrap_or_default();
            if result.unconverged > 0 {
                let (count, residual) = (result.unconverged, result.residual);
                said += &format!("{count} solves not converged; residual at most {residual:.1e}");
            }
            context.add_run(&result);
            said
        }
        Err(error) => error.to_string().lines().next().unwrap_or_default().to_owned(),
    };
    // "bounded" accepts every state but growing and refused; any other word is the name of the one required state.
    let as_required = match case.expect.as_str() {
        "bounded" => state != RunState::Growing && state != RunState::Refused,
        name => name == row.state,
    };
    row.passed = Some(as_required && said.contains(&case.says));
    row.note = format!("expected: {}; {said}", case.expect);
    row
}
