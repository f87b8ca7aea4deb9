//! The step limit that is predicted, beside the one that is observed by bisection.

use super::catalogue::{Map, StabilityCatalogue};
use super::map::settings_of;
use super::state::{State, judge};
use super::{Scenes, Task, trial};
use crate::{Row, Setup};
use std::path::Path;

/// Steps of a run: enough for what grows by 2 % a step from rounding to be seen.
const STEPS: u32 = 2000;
/// Of the observed limit over the predicted one: a limit that is not safe, or that wastes more than this, has missed.
const ALLOWED: (f64, f64) = (0.999, 1.25);

pub(super) fn tasks<'a>(
    (catalogue, folder): (&'a StabilityCatalogue, &'a Path),
    scenes: Scenes<'a>,
    setup: &Setup<'_>,
    out: &mut Vec<Task<'a>>,
) {
    let every = if setup.quick { 3 } else { 1 };
    for map in catalogue.map.iter().filter(|m| m.limit) {
        let explicit = map.integrator.iter().filter(|i| ["symplectic-euler", "explicit-euler"].contains(&i.as_str()));
        for integrator in explicit {
            for point in (0..map.point.len()).step_by(every) {
                let case = format!("limit-{}", map.name);
                let (method, threads) = (integrator.clone(), setup.threads);
                let mut row = Row { case, method, threads, ..Row::default() };
                row.at.insert(map.along.clone(), map.point[point].value);
                out.push((row, Box::new(move |row, setup| fill((map, folder), point, scenes, row, setup))));
            }
        }
    }
}

fn fill<'a>(
    (map, folder): (&'a Map, &'a Path),
    point: usize,
    scenes: Scenes<'a>,
    mut row: Row,
    setup: &mut Setup<'_>,
) -> Row {
    let map = Map { steps: if setup.quick { STEPS / 4 } else { STEPS }, ..map.clone() };
    let mut grows = |dt: f64| -> Option<(bool, Option<f64>)> {
        let sets = settings_of((&map, folder), point, &row.method, dt);
        let (state, _, outcome) = judge(&trial(scenes, &map.scene, sets, setup)?);
        let outcome = outcome.ok()?;
        setup.ran(&outcome);
        row.wall_seconds += outcome.wall;
        row.cpu_seconds += outcome.cpu;
        Some((state == State::Growing, outcome.choices.step_limit))
    };
    // Any step tells what is predicted.
    let Some((_, Some(predicted))) = grows(1e-9) else {
        row.note = "no limit is predicted".into();
        row.passed = Some(false);
        return row;
    };
    let (mut stable, mut growing) = (0.25 * predicted, 4.0 * predicted);
    let ends = (grows(stable), grows(growing));
    if ends.0.is_none_or(|e| e.0) || ends.1.is_none_or(|e| !e.0) {
        row.note = format!("grows at a quarter of the limit, {stable:.3e} s, or not at four times it");
        row.passed = Some(false);
        return row;
    }
    for _ in 0..8 {
        let middle = (stable * growing).sqrt();
        match grows(middle) {
            Some((true, _)) => growing = middle,
            _ => stable = middle,
        }
    }
    let observed = (stable * growing).sqrt();
    let ratio = observed / predicted;
    row.dt = predicted;
    row.found.extend([("predicted".into(), predicted), ("observed".into(), observed), ("ratio".into(), ratio)]);
    (row.error, row.tolerance) = (Some((ratio - 1.0).abs()), Some(ALLOWED.1 - 1.0));
    row.passed = Some((ALLOWED.0..=ALLOWED.1).contains(&ratio));
    if ratio < ALLOWED.0 {
        row.note = "it grows below the predicted limit".into();
    }
    row
}
