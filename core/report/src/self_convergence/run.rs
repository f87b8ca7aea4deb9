//! Runs the refinement series of a scene and compares each run with its reference.

use super::page::sections;
use super::series::{LEVEL, RefinementSeries, STEP, refinement_series};
use crate::catalogue::NotRun;
use crate::context::ReportContext;
use crate::document::Measurements;
use crate::fit::{ErrorAt, order, pareto_front};
use crate::journal::Journal;
use crate::plot::format_short;
use crate::row::Row;
use crate::scene_run::{RunResult, SceneRun};
use pliant_engine::scene::Scene;
use pliant_engine::session::SessionError;
use pliant_solver::Vec3;
use std::path::Path;

/// A scene that is compared with its own refined solution.
#[derive(Clone, Copy)]
pub struct SceneInput<'a> {
    /// File of the scene; paths in it are relative to its folder.
    pub path: &'a Path,
    /// Text of the scene.
    pub text: &'a str,
    /// Values that take the place of the scene's, as `--set` takes them.
    pub settings: &'a [(String, String)],
}

/// Quantities by which two runs are compared, in the order of the rows of a run.
const COMPARED: [&str; 2] = ["force on the hands", "surface at the end"];

/// Largest difference of the forces from a refined run that passes, relative: people tell forces apart that differ by 7 to 10 % (Jones 1989).
const FORCE_TOLERANCE: f64 = 0.1;

/// Forces and surfaces of a run.
struct Trajectory {
    /// Forces on all tools at common times, N (times x tools).
    forces: Vec<Vec3>,
    /// Vertices of all surfaces at the end, m.
    surface: Vec<Vec3>,
    /// Largest displacement of a vertex during the run, m.
    largest_displacement: f64,
}

/// Runs a scene at several steps, solver tolerances and grid levels, and compares them with the finest of each.
///
/// # Errors
/// Returns an error if the scene cannot be opened with its own settings. Refined scenes that cannot be opened are listed as not run.
pub fn self_convergence(
    scene_input: SceneInput<'_>,
    context: &mut ReportContext<'_>,
    journal: &mut Journal,
) -> Result<Measurements, SessionError> {
    let (scene, session) = scene_run(scene_input, scene_input.settings.to_vec(), context).open()?;
    let all = refinement_series(&scene, &session, context.options.quick);
    let lattice = session.bodies.first().and_then(|body| body.discretization.lattice());
    let level = lattice.map_or(0, |lattice| u64::from(lattice.settings.level));
    drop(session);
    let total = all.iter().map(|series| series.values.len()).sum();
    let (mut done, mut rows, mut not_run) = (0, Vec::new(), Vec::new());
    for series in &all {
        let threads = context.options.threads;
        let empty: Vec<[Row; 2]> =
            series.values.iter().map(|v| empty_rows(scene_input.path, series, *v, &scene, level, threads)).collect();
        let known = |rows: &[Row; 2]| Some([journal.get(&rows[0].key())?, journal.get(&rows[1].key())?]);
        let old: Option<Vec<[Row; 2]>> = empty[..empty.len() - 1].iter().map(known).collect();
        if let Some(old) = old {
            done += series.values.len();
            rows.extend(old.into_iter().flatten());
            continue;
        }
        // Forces are compared at multiples of the coarsest step.
        let sample_period = if series.path == STEP { series.values[0] } else { scene.time.dt.get_ref().si };
        // The reference is run first: the others are compared with it.
        let mut reference: Option<Trajectory> = None;
        let mut of_series = Vec::new();
        for (value, empty) in series.values.iter().zip(empty).rev() {
            if context.is_stopped() {
                return Ok(Measurements { rows, sections: Vec::new(), not_run });
            }
            context.announce(done, total, &format!("{}, {} = {value}", series.name, series.path));
            done += 1;
            let mut settings = scene_input.settings.to_vec();
            settings.extend(series.settings.iter().cloned());
            settings.push((series.path.to_owned(), value.to_string()));
            let tracked = run_and_track(&scene_run(scene_input, settings, context), sample_period);
            if context.is_stopped() {
                return Ok(Measurements { rows, sections: Vec::new(), not_run });
            }
            match (tracked, &reference) {
                (Err(error), _) => {
                    let case = format!("{}, {} = {}", series.name, series.path, format_short(*value));
                    not_run.push(NotRun { case, why: error.to_string() });
                    if reference.is_none() {
                        break;
                    }
                }
                (Ok((result, trajectory)), None) => {
                    context.add_run(&result);
                    reference = Some(trajectory);
                }
                (Ok((result, trajectory)), Some(reference)) => {
                    context.add_run(&result);
                    for (mut row, error) in empty.into_iter().zip(errors(&trajectory, reference)) {
                        row.error = error.is_finite().then_some(error);
                        row.set_cost(&result);
                        row.note = result.frozen.clone().unwrap_or_default();
                        judge_forces(series, *value, &mut row);
                        of_series.push(row);
                    }
                }
            }
        }
        of_series.reverse();
        fill_orders(series, &mut of_series);
        of_series.iter().for_each(|row| journal.put(row));
        rows.extend(of_series);
    }
    fill_fronts(&mut rows);
    let sections = sections(&all, &rows);
    Ok(Measurements { rows, sections, not_run })
}

/// A run of the scene with settings.
fn scene_run<'a>(
    scene: SceneInput<'a>,
    settings: Vec<(String, String)>,
    context: &'a ReportContext<'_>,
) -> SceneRun<'a> {
    let (threads, search, clock) = (context.options.threads, &context.options.search, context.options.clock);
    SceneRun { path: scene.path, text: scene.text, settings, threads, search, clock, stop: context.stop() }
}

/// The rows of one run, one for each of [`COMPARED`], with all that is set and nothing that is measured. `level` is that of the grid of the first body,
/// 0 without one.
fn empty_rows(
    path: &Path,
    series: &RefinementSeries,
    value: f64,
    scene: &Scene,
    level: u64,
    threads: usize,
) -> [Row; 2] {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    COMPARED.map(|what| {
        let mut row = Row {
            case: format!("{name}: {what}"),
            method: series.name.clone(),
            n: if series.path == LEVEL { value as u64 } else { level },
            dt: if series.path == STEP { value } else { scene.time.dt.get_ref().si },
            threads,
            ..Row::default()
        };
        row.parameters.insert(series.path.into(), value);
        row
    })
}

/// Runs a scene and keeps its forces, `sample_period` (s) apart, and its last surface.
fn run_and_track(run: &SceneRun<'_>, sample_period: f64) -> Result<(RunResult, Trajectory), SessionError> {
    let mut found = Trajectory { forces: Vec::new(), surface: Vec::new(), largest_displacement: 0.0 };
    let mut next = sample_period;
    let result = run.run(&[], |session| {
        if session.time() >= next * (1.0 - 1e-9) {
            found.forces.extend(session.frame().tools.iter().map(|t| t.force));
            next += sample_period;
        }
        session.update_surface();
        found.surface.clear();
        for body in &session.bodies {
            for (x, rest) in body.skin.x.iter().zip(&body.model.surface.points) {
                found.surface.push(*x);
                let u = *x - *rest;
                found.largest_displacement = found.largest_displacement.max(u.norm());
            }
        }
        true
    })?;
    Ok((result, found))
}

/// Errors in the order of [`COMPARED`]: root mean square of the force's difference over that of the force, and the surface's largest
/// difference over its largest displacement. NaN where there is nothing to compare.
fn errors(a: &Trajectory, reference: &Trajectory) -> [f64; 2] {
    let off: f64 = a.forces.iter().zip(&reference.forces).map(|(a, b)| (*a - *b).norm_squared()).sum();
    let whole: f64 = reference.forces.iter().map(|b| b.norm_squared()).sum();
    if a.surface.len() != reference.surface.len() {
        return [(off / whole).sqrt(), f64::NAN];
    }
    let distances = a.surface.iter().zip(&reference.surface).map(|(a, b)| (*a - *b).norm());
    [(off / whole).sqrt(), distances.fold(0.0, f64::max) / reference.largest_displacement]
}

/// Judges the forces of the run with the scene's own settings; other runs and the surface have no criterion.
fn judge_forces(series: &RefinementSeries, value: f64, row: &mut Row) {
    let is_of_forces = row.case.ends_with(COMPARED[0]);
    let Some(error) = row.error.filter(|_| is_of_forces && series.own == Some(value)) else { return };
    row.tolerance = Some(FORCE_TOLERANCE);
    row.passed = Some(error <= FORCE_TOLERANCE);
    if error > FORCE_TOLERANCE {
        let said = format!(
            "with the scene's own {} of {} its forces are {:.0} % off those of a refined run",
            series.path,
            format_short(value),
            100.0 * error
        );
        row.note = if row.note.is_empty() { said } else { format!("{}; {said}", row.note) };
    }
}

/// Fills in the order between a run and the next coarser one; rows of both comparisons alternate.
fn fill_orders(series: &RefinementSeries, rows: &mut [Row]) {
    let size = |r: &Row| {
        let value = r.parameters[series.path];
        // A cell halves with each level.
        if series.path == LEVEL { 0.5_f64.powf(value) } else { value }
    };
    for i in COMPARED.len()..rows.len() {
        let (coarse, fine) = (&rows[i - COMPARED.len()], &rows[i]);
        if let (Some(a), Some(b)) = (coarse.error, fine.error) {
            rows[i].order = order(ErrorAt { size: size(coarse), error: a }, ErrorAt { size: size(fine), error: b });
        }
    }
}

/// Fills in the Pareto front of each comparison.
fn fill_fronts(rows: &mut [Row]) {
    let mut cases: Vec<String> = rows.iter().map(|r| r.case.clone()).collect();
    cases.sort();
    cases.dedup();
    for case in cases {
        let of: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].case == case).collect();
        let points: Vec<_> = of.iter().map(|&i| (rows[i].wall_seconds, rows[i].error.unwrap_or(f64::NAN))).collect();
        of.iter().zip(pareto_front(&points)).for_each(|(&i, on_front)| rows[i].on_front = on_front);
    }
}
