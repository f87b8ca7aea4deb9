//! Runs the refinement series of a scene and compares each run with its reference.

use super::front::{Front, Settings, describe};
use super::page::sections;
use super::series::{LEVEL, RefinementSeries, STEP, TOLERANCE, fronts};
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

/// A run with which others are compared.
struct Reference {
    /// Its settings, as people read them.
    text: String,
    /// What it computed.
    trajectory: Trajectory,
}

/// Runs a scene at several steps, solver tolerances and grid levels, and compares all that compute the same thing with the most accurate run of it.
///
/// # Errors
/// Returns an error if the scene cannot be opened with its own settings. Refined scenes that cannot be opened are listed as not run.
pub fn self_convergence(
    scene_input: SceneInput<'_>,
    context: &mut ReportContext<'_>,
    journal: &mut Journal,
) -> Result<Measurements, SessionError> {
    let (scene, session) = scene_run(scene_input, scene_input.settings.to_vec(), context).open()?;
    let fronts = fronts(&scene, &session, context.options.quick);
    let lattice = session.bodies.first().and_then(|body| body.discretization.lattice());
    let level = lattice.map_or(0, |lattice| u64::from(lattice.settings.level));
    drop(session);
    let total =
        fronts.iter().map(|front| 1 + front.series.iter().map(|series| series.values.len()).sum::<usize>()).sum();
    let mut runs = Runs { scene_input, done: 0, total, not_run: Vec::new() };
    let mut rows = Vec::new();
    for front in &fronts {
        let empty = |series: &RefinementSeries| -> Vec<[Row; 2]> {
            let row = |value: &f64| {
                empty_rows(scene_input.path, front, series, *value, &scene, level, context.options.threads)
            };
            series.values.iter().map(row).collect()
        };
        let empty: Vec<Vec<[Row; 2]>> = front.series.iter().map(empty).collect();
        let known = |rows: &[Row; 2]| Some([journal.get(&rows[0].key())?, journal.get(&rows[1].key())?]);
        let old: Vec<Option<Vec<[Row; 2]>>> = empty.iter().map(|rows| rows.iter().map(known).collect()).collect();
        let reference = if old.iter().all(Option::is_some) {
            runs.done += 1;
            None
        } else {
            runs.reference(front, context)
        };
        for ((series, empty), old) in front.series.iter().zip(empty).zip(old) {
            if let Some(old) = old {
                runs.done += series.values.len();
                rows.extend(old.into_iter().flatten());
                continue;
            }
            let Some(reference) = &reference else { continue };
            let mut of_series = Vec::new();
            for (value, empty) in series.values.iter().zip(empty) {
                if let Some((result, trajectory)) = runs.run_at(front, series, *value, context) {
                    for (mut row, error) in empty.into_iter().zip(errors(&trajectory, &reference.trajectory)) {
                        row.error = error.is_finite().then_some(error);
                        row.reference.clone_from(&reference.text);
                        row.set_cost(&result);
                        row.note = result.frozen.clone().unwrap_or_default();
                        judge_forces(series, *value, &mut row);
                        of_series.push(row);
                    }
                }
                if context.is_stopped() {
                    return Ok(Measurements { rows, sections: Vec::new(), not_run: runs.not_run });
                }
            }
            fill_orders(series, &mut of_series);
            of_series.iter().for_each(|row| journal.put(row));
            rows.extend(of_series);
        }
        if context.is_stopped() {
            return Ok(Measurements { rows, sections: Vec::new(), not_run: runs.not_run });
        }
    }
    fill_fronts(&mut rows);
    let sections = sections(&fronts, &rows);
    Ok(Measurements { rows, sections, not_run: runs.not_run })
}

/// The runs of a report so far.
struct Runs<'a> {
    /// The scene and the settings of the command, which all runs have.
    scene_input: SceneInput<'a>,
    /// Number of runs that are done, or known from before.
    done: usize,
    /// Number of all runs.
    total: usize,
    /// Runs that could not be made.
    not_run: Vec<NotRun>,
}

impl Runs<'_> {
    /// The reference of a front; `None` if none of its candidates opens and converges.
    fn reference(&mut self, front: &Front, context: &mut ReportContext<'_>) -> Option<Reference> {
        self.done += 1;
        for settings in &front.references {
            let text = describe(settings);
            context.announce(self.done - 1, self.total, &format!("reference: {text}"));
            match self.run(settings, front.sample_period, context) {
                _ if context.is_stopped() => return None,
                Ok((result, trajectory)) => match unusable(&result) {
                    None => return Some(Reference { text, trajectory }),
                    Some(why) => self.not_run.push(NotRun { case: format!("reference: {text}"), why }),
                },
                Err(error) => self.not_run.push(NotRun { case: format!("reference: {text}"), why: error.to_string() }),
            }
        }
        None
    }

    /// The run of a series at a value; `None` if it cannot be opened.
    fn run_at(
        &mut self,
        front: &Front,
        series: &RefinementSeries,
        value: f64,
        context: &mut ReportContext<'_>,
    ) -> Option<(RunResult, Trajectory)> {
        context.announce(self.done, self.total, &format!("{}, {} = {value}", series.name, series.path));
        self.done += 1;
        let mut settings = series.settings.clone();
        settings.push((series.path.to_owned(), value.to_string()));
        match self.run(&settings, front.sample_period, context) {
            _ if context.is_stopped() => None,
            Ok(found) => Some(found),
            Err(error) => {
                let case = format!("{}, {} = {}", series.name, series.path, format_short(value));
                self.not_run.push(NotRun { case, why: error.to_string() });
                None
            }
        }
    }

    /// A run of the scene with settings, those of the command first.
    fn run(
        &self,
        settings: &Settings,
        sample_period: f64,
        context: &mut ReportContext<'_>,
    ) -> Result<(RunResult, Trajectory), SessionError> {
        let all = [self.scene_input.settings, settings].concat();
        let found = run_and_track(&scene_run(self.scene_input, all, context), sample_period)?;
        context.add_run(&found.0);
        Ok(found)
    }
}

/// Why a run cannot be a reference; `None` if it can.
fn unusable(result: &RunResult) -> Option<String> {
    let unconverged = (result.unconverged > 0).then(|| format!("{} solves did not converge", result.unconverged));
    result.frozen.clone().or(unconverged)
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
    front: &Front,
    series: &RefinementSeries,
    value: f64,
    scene: &Scene,
    level: u64,
    threads: usize,
) -> [Row; 2] {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    COMPARED.map(|what| {
        let mut row = Row {
            case: format!("{name}{}: {what}", front.name),
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
        row.add_note(&format!(
            "with the scene's own {} of {} its forces are {:.0} % off those of a refined run",
            series.path,
            format_short(value),
            100.0 * error
        ));
    }
}

/// Fills in the order between a run and the next coarser one; rows of both comparisons alternate. A tolerance has no order: beyond the error of the step it
/// changes nothing.
fn fill_orders(series: &RefinementSeries, rows: &mut [Row]) {
    if series.path == TOLERANCE {
        return;
    }
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
