//! Values at the ends of what is allowed and beyond: what happened, beside what must.

use super::catalogue::{Extreme, StabilityCatalogue};
use super::state::{State, judge};
use super::{Scenes, Task, trial};
use crate::catalogue::settings;
use crate::{Row, Setup};

pub(super) fn tasks<'a>(
    catalogue: &'a StabilityCatalogue,
    scenes: Scenes<'a>,
    setup: &Setup<'_>,
    out: &mut Vec<Task<'a>>,
) {
    for extreme in &catalogue.extreme {
        let (case, method) = ("extreme".to_owned(), extreme.name.clone());
        let row = Row { case, method, threads: setup.threads, ..Row::default() };
        out.push((row, Box::new(move |row, setup| fill(extreme, scenes, row, setup))));
    }
}

fn fill<'a>(extreme: &'a Extreme, scenes: Scenes<'a>, mut row: Row, setup: &mut Setup<'_>) -> Row {
    let Some(trial) = trial(scenes, &extreme.scene, settings([&extreme.set]), setup) else {
        row.note = format!("no scene `{}`", extreme.scene);
        row.passed = Some(false);
        return row;
    };
    let (state, ledger, outcome) = judge(&trial);
    row.state = state.name().into();
    let said = match outcome {
        Ok(outcome) => {
            row.dt = outcome.dt;
            (row.wall_seconds, row.cpu_seconds, row.iterations) = (outcome.wall, outcome.cpu, outcome.iterations);
            row.found.insert("energy from nothing (share)".into(), ledger.excess().min(1e300));
            row.found.insert("residual".into(), outcome.residual);
            let mut said = outcome.frozen.clone().unwrap_or_default();
            if outcome.unconverged > 0 {
                said +=
                    &format!("{} solves not converged; residual at most {:.1e}", outcome.unconverged, outcome.residual);
            }
            setup.ran(&outcome);
            said
        }
        Err(error) => error.to_string().lines().next().unwrap_or_default().to_owned(),
    };
    let as_asked = match extreme.expect.as_str() {
        "bounded" => state != State::Growing && state != State::Refused,
        word => word == row.state,
    };
    row.passed = Some(as_asked && said.contains(&extreme.says));
    row.note = format!("expected: {}; {said}", extreme.expect);
    row
}
