//! A state for every step and every value of one other thing, by integrator. Explicit integrators are forced, so that the map
//! shows what happens and not what is refused; the limit the program predicts, and refuses beyond, is drawn into it.

use super::catalogue::{Map, StabilityCatalogue};
use super::state::{State, judge};
use super::{Scenes, Task, graded, set, trial};
use crate::catalogue::settings;
use crate::{Row, Setup};
use std::path::Path;

pub(super) fn tasks<'a>(
    (catalogue, folder): (&'a StabilityCatalogue, &'a Path),
    scenes: Scenes<'a>,
    setup: &Setup<'_>,
    out: &mut Vec<Task<'a>>,
) {
    // A quick map has every second line of each kind.
    let every = if setup.quick { 2 } else { 1 };
    for map in &catalogue.map {
        for integrator in &map.integrator {
            for point in (0..map.point.len()).step_by(every) {
                for dt in map.step.iter().step_by(every) {
                    let row = blank(map, integrator, point, *dt, setup);
                    out.push((row, Box::new(move |row, setup| fill((map, folder), point, scenes, row, setup))));
                }
            }
        }
    }
}

fn blank(map: &Map, integrator: &str, point: usize, dt: f64, setup: &Setup<'_>) -> Row {
    let mut row =
        Row { case: map.name.clone(), method: integrator.into(), dt, threads: setup.threads, ..Row::default() };
    row.at.insert(map.along.clone(), map.point[point].value);
    row
}

/// What makes a run of a map.
pub(super) fn settings_of(
    (map, folder): (&Map, &Path),
    point: usize,
    integrator: &str,
    dt: f64,
) -> Vec<(String, String)> {
    let mut all = settings([&map.point[point].set]);
    if map.graded {
        all.push(set("body.0.mesh", graded::path(folder, map.point[point].value).display()));
    }
    let forced = ["explicit-euler", "symplectic-euler"].contains(&integrator);
    all.extend([
        set("time.integrator", integrator),
        set("time.dt", dt),
        set("time.duration", dt * f64::from(map.steps)),
        set("time.substeps", 1),
        set("time.force-unstable", forced),
    ]);
    all
}

fn fill<'a>(
    (map, folder): (&'a Map, &'a Path),
    point: usize,
    scenes: Scenes<'a>,
    mut row: Row,
    setup: &mut Setup<'_>,
) -> Row {
    let sets = settings_of((map, folder), point, &row.method, row.dt);
    let Some(trial) = trial(scenes, &map.scene, sets, setup) else {
        row.note = format!("no scene `{}`", map.scene);
        return row;
    };
    let (state, ledger, outcome) = judge(&trial);
    row.state = state.name().into();
    row.found.insert("energy from nothing (share)".into(), ledger.excess().min(1e300));
    match outcome {
        Ok(outcome) => {
            (row.wall_seconds, row.cpu_seconds, row.iterations) = (outcome.wall, outcome.cpu, outcome.iterations);
            if let Some(limit) = outcome.choices.step_limit {
                row.found.insert("predicted".into(), limit);
                // What the program calls stable must be.
                row.passed = Some(row.dt > limit || state != State::Growing);
            } else {
                row.passed = None;
            }
            setup.ran(&outcome);
        }
        Err(error) => row.note = error.to_string(),
    }
    row
}
