//! Any scene against its own refined solution: what its step, its solver's tolerance and its grid cost in error.
//!
//! The reference is the same scene with a step, tolerance or cell as much finer as the report affords. What is left of the
//! discretisation is then the difference of two solutions, and its order says whether refining goes anywhere (Roache 1998).

use super::catalogue::NotRun;
use super::page::{Section, Table};
use super::plot::{Axis, Curve, Lines, short};
use super::{Journal, Measured, Row, Setup, Trial, front, order};
use pliant_engine::scene::{IntegratorChoice, Scene};
use pliant_engine::session::{Session, SessionError};
use pliant_solver::{V3, axpy, dot};
use std::path::Path;

/// What two runs are compared by.
struct Track {
    /// N, on every tool, at common times
    forces: Vec<V3>,
    /// m, the surfaces at the end
    surface: Vec<V3>,
    /// m, how far the surface has moved at most
    moved: f64,
}

/// One thing that is refined.
struct Line {
    /// For rows.
    name: String,
    /// What is refined, for the picture.
    axis: &'static str,
    /// Set in all of its runs.
    set: Vec<(String, String)>,
    /// Path of what is refined, and its values from coarse to fine; the last is the reference.
    path: &'static str,
    values: Vec<f64>,
}

/// Runs a scene at several resolutions. `set` is put in the place of what it says.
///
/// # Errors
/// A scene that cannot be opened as it is.
pub fn own_scene(
    (path, text, set): (&Path, &str, &[(String, String)]),
    setup: &mut Setup<'_>,
    journal: &mut Journal,
) -> Result<Measured, SessionError> {
    let clock = setup.clock;
    let as_it_is = Trial { path, text, set: set.to_vec(), threads: setup.threads, search: &setup.search, clock };
    let (scene, session) = as_it_is.open()?;
    let lines = lines(&scene, &session, setup.quick);
    drop(session);
    let all = lines.iter().map(|l| l.values.len()).sum();
    let (mut done, mut rows, mut not_run) = (0, Vec::new(), Vec::new());
    for line in &lines {
        let coarsest = match line.path {
            "time.dt" => line.values[0],
            _ => scene.time.dt.get_ref().si,
        };
        let blanks: Vec<[Row; 2]> = line.values.iter().map(|v| blank(path, line, *v, &scene, setup)).collect();
        let known = |b: &[Row; 2]| Some([journal.get(&b[0].key())?, journal.get(&b[1].key())?]);
        let old: Option<Vec<[Row; 2]>> = blanks[..blanks.len() - 1].iter().map(known).collect();
        if let Some(old) = old {
            done += line.values.len();
            rows.extend(old.into_iter().flatten());
            continue;
        }
        // The reference first: without it the others say nothing.
        let mut reference: Option<Track> = None;
        let mut of_line = Vec::new();
        for (value, blank) in line.values.iter().zip(blanks).rev() {
            if (setup.stopped)() {
                return Ok((rows, Vec::new(), not_run));
            }
            (setup.progress)(done, all, &format!("{}, {} = {value}", line.name, line.path));
            done += 1;
            let mut set = set.to_vec();
            set.extend(line.set.iter().cloned());
            set.push((line.path.to_owned(), value.to_string()));
            let trial = Trial { path, text, set, threads: setup.threads, search: &setup.search, clock };
            match (track(&trial, coarsest), &reference) {
                (Err(error), _) => {
                    let case = format!("{}, {} = {}", line.name, line.path, short(*value));
                    let why = error.to_string();
                    not_run.push(NotRun { case, why });
                    if reference.is_none() {
                        break;
                    }
                }
                (Ok((outcome, found)), None) => {
                    setup.ran(&outcome);
                    reference = Some(found);
                }
                (Ok((outcome, found)), Some(reference)) => {
                    setup.ran(&outcome);
                    let errors = compare(&found, reference);
                    for (mut row, error) in blank.into_iter().zip(errors) {
                        row.error = error.is_finite().then_some(error);
                        (row.wall_seconds, row.cpu_seconds, row.open_seconds) =
                            (outcome.wall, outcome.cpu, outcome.open);
                        (row.bytes, row.iterations) = (outcome.bytes, outcome.iterations);
                        row.note = outcome.frozen.clone().unwrap_or_default();
                        of_line.push(row);
                    }
                }
            }
        }
        of_line.reverse();
        orders(line, &mut of_line);
        of_line.iter().for_each(|row| journal.put(row));
        rows.extend(of_line);
    }
    mark(&mut rows);
    let sections = sections(&lines, &rows);
    Ok((rows, sections, not_run))
}

/// What there is to refine in a scene.
fn lines(scene: &Scene, session: &Session, quick: bool) -> Vec<Line> {
    let dt = scene.time.dt.get_ref().si;
    let factors = if quick { &[4.0, 2.0, 1.0, 0.25][..] } else { &[8.0, 4.0, 2.0, 1.0, 0.5, 0.125] };
    let steps: Vec<f64> = factors.iter().map(|f| f * dt).collect();
    let own = session.choices.integrator;
    let mut out = Vec::new();
    for name in ["symplectic-euler", "backward-euler", "bdf2"] {
        let chosen = scene.time.integrator == IntegratorChoice::Auto && name == own;
        if name != own && quick || own == "quasi-static" {
            continue;
        }
        let why = if chosen { ", chosen" } else { "" };
        let set = vec![("time.integrator".into(), name.into())];
        out.push(Line { name: format!("{name}{why}"), axis: "step (s)", set, path: "time.dt", values: steps.clone() });
    }
    if own == "quasi-static" {
        out.push(Line { name: own.into(), axis: "step (s)", set: vec![], path: "time.dt", values: steps });
    }
    if !["symplectic-euler", "explicit-euler"].contains(&own) {
        let values = vec![1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-10];
        let (name, axis) = (format!("{own}, solver"), "relative residual of the solver (1)");
        out.push(Line { name, axis, set: vec![], path: "solver.tolerance", values });
    }
    let lattice = scene.body.first().filter(|b| b.sheet.is_none() && *b.grid.level.get_ref() > 3);
    if let Some(body) = lattice {
        let level = f64::from(*body.grid.level.get_ref());
        // A region of so many cells would shrink with them.
        let radius = session.bodies.first().map(|b| b.carrier.radius()).filter(|r| r.is_finite());
        let set = radius.map(|r| ("body.0.grid.radius".to_owned(), r.to_string())).into_iter().collect();
        let values = if quick {
            vec![level - 1.0, level, level + 1.0]
        } else {
            vec![level - 2.0, level - 1.0, level, level + 1.0]
        };
        out.push(Line {
            name: format!("{own}, grid"),
            axis: "level of the grid (1)",
            set,
            path: "body.0.grid.level",
            values,
        });
    }
    out
}

fn blank(path: &Path, line: &Line, value: f64, scene: &Scene, setup: &Setup<'_>) -> [Row; 2] {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    ["force on the hands", "surface at the end"].map(|what| {
        let level = scene.body.first().filter(|b| b.sheet.is_none()).map_or(0, |b| u64::from(*b.grid.level.get_ref()));
        let mut row = Row {
            case: format!("{name}: {what}"),
            method: line.name.clone(),
            n: if line.path == "body.0.grid.level" { value as u64 } else { level },
            dt: if line.path == "time.dt" { value } else { scene.time.dt.get_ref().si },
            threads: setup.threads,
            ..Row::default()
        };
        row.at.insert(line.path.into(), value);
        row
    })
}

/// Runs one, keeping what is compared. `every` (s): how far apart forces are kept.
fn track(trial: &Trial<'_>, every: f64) -> Result<(super::Outcome, Track), SessionError> {
    let mut found = Track { forces: Vec::new(), surface: Vec::new(), moved: 0.0 };
    let mut next = every;
    let outcome = trial.run(&[], |session| {
        if session.time() >= next * (1.0 - 1e-9) {
            found.forces.extend(session.frame().tools.iter().map(|t| t.force));
            next += every;
        }
        session.update_surface();
        found.surface.clear();
        for body in &session.bodies {
            for (x, rest) in body.skin.x.iter().zip(&body.model.surface.points) {
                found.surface.push(*x);
                let u = axpy(*x, -1.0, *rest);
                found.moved = found.moved.max(dot(u, u).sqrt());
            }
        }
        true
    })?;
    Ok((outcome, found))
}

/// Root mean square of the force's difference over that of the force; the surface's largest difference over its largest
/// displacement. Not a number where there is nothing to compare.
fn compare(a: &Track, reference: &Track) -> [f64; 2] {
    let square = |v: V3| dot(v, v);
    let off: f64 = a.forces.iter().zip(&reference.forces).map(|(a, b)| square(axpy(*a, -1.0, *b))).sum();
    let whole: f64 = reference.forces.iter().map(|b| square(*b)).sum();
    if a.surface.len() != reference.surface.len() {
        return [(off / whole).sqrt(), f64::NAN];
    }
    let away = a.surface.iter().zip(&reference.surface).map(|(a, b)| square(axpy(*a, -1.0, *b)).sqrt());
    [(off / whole).sqrt(), away.fold(0.0, f64::max) / reference.moved]
}

fn orders(line: &Line, rows: &mut [Row]) {
    let cell = |v: f64| if line.path == "body.0.grid.level" { 0.5_f64.powf(v) } else { v };
    for i in 2..rows.len() {
        let (coarse, fine) = (&rows[i - 2], &rows[i]);
        let size = |r: &Row| cell(r.at[line.path]);
        if let (Some(a), Some(b)) = (coarse.error, fine.error) {
            rows[i].order = order((size(coarse), a), (size(fine), b));
        }
    }
}

fn mark(rows: &mut [Row]) {
    let mut cases: Vec<String> = rows.iter().map(|r| r.case.clone()).collect();
    cases.sort();
    cases.dedup();
    for case in cases {
        let of: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].case == case).collect();
        let points: Vec<_> = of.iter().map(|&i| (rows[i].wall_seconds, rows[i].error.unwrap_or(f64::NAN))).collect();
        of.iter().zip(front(&points)).for_each(|(&i, on)| rows[i].front = on);
    }
}

fn sections(lines: &[Line], rows: &[Row]) -> Vec<Section> {
    let mut cases: Vec<&str> = rows.iter().filter(|r| r.error.is_some()).map(|r| r.case.as_str()).collect();
    cases.sort_unstable();
    cases.dedup();
    let section = |case: &&str| {
        let of = |line: &Line| -> Vec<&Row> {
            rows.iter().filter(|r| r.case == **case && r.method == line.name && r.error.is_some()).collect()
        };
        let curve = |line: &Line, x: &dyn Fn(&Row) -> f64, marked: bool| Curve {
            name: line.name.clone(),
            points: of(line).iter().map(|r| (x(r), r.error.unwrap_or(f64::NAN).max(1e-16))).collect(),
            large: of(line).iter().map(|r| marked && r.front).collect(),
            theory: false,
        };
        let slug = |text: &str| text.replace([' ', ':', ',', '.'], "-").replace("--", "-");
        let work = Lines {
            title: format!("{case}: error against run time"),
            x: Axis::log("wall-clock time of the steps (s)"),
            y: Axis::log("difference from the reference (relative, 1)"),
            curves: lines
                .iter()
                .map(|l| curve(l, &|r| r.wall_seconds, true))
                .filter(|c| !c.points.is_empty())
                .collect(),
        };
        let mut plots = vec![(format!("{}-work", slug(case)), work.svg())];
        for path in ["time.dt", "solver.tolerance", "body.0.grid.level"] {
            let along: Vec<&Line> = lines.iter().filter(|l| l.path == path && !of(l).is_empty()).collect();
            let Some(first) = along.first() else { continue };
            let picture = Lines {
                title: format!("{case}: against {}", first.axis),
                x: if path.ends_with("level") { Axis::linear(first.axis) } else { Axis::log(first.axis) },
                y: Axis::log("difference from the reference (relative, 1)"),
                curves: along.iter().map(|l| curve(l, &|r| r.at[path], false)).collect(),
            };
            plots.push((format!("{}-{}", slug(case), slug(path)), picture.svg()));
        }
        let head = ["what is refined", "value", "error (1)", "order", "wall (s)", "CPU (s)", "iterations", "front"];
        let mut table = Table { caption: "Runs".into(), head: head.map(String::from).to_vec(), rows: vec![] };
        for r in lines.iter().flat_map(of) {
            let (path, value) = r.at.first_key_value().map_or(("", 0.0), |(k, v)| (k.as_str(), *v));
            let error = r.error.map_or_else(|| "-".into(), short);
            let order = r.order.map_or_else(|| "-".into(), |o| format!("{o:.2}"));
            let (wall, cpu) = (short(r.wall_seconds), short(r.cpu_seconds));
            let front = if r.front { "yes" } else { "" };
            let method = format!("{}: {path}", r.method);
            let cells = vec![method, short(value), error, order, wall, cpu, r.iterations.to_string(), front.into()];
            table.rows.push((cells, false));
        }
        let text = "The same scene, refined, is the reference. Force: root mean square of the difference over that of the \
                    force, at common times, before force safety. Surface: largest distance at the end over the largest \
                    displacement.";
        Section { title: (*case).into(), text: vec![text.into()], plots, tables: vec![table] }
    };
    cases.iter().map(section).collect()
}
