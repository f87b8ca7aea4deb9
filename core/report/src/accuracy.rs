//! Every case with every method at every resolution: error, order, cost.

use super::catalogue::{Case, Catalogue, Method, Over, settings};
use super::journal::Journal;
use super::measure::Measure;
use super::{Row, Setup, Trial, front, order};
use std::path::Path;

/// How far below the expected order an observed one may be.
const ORDER_SLACK: f64 = 0.3;

/// Runs a catalogue. `scene` gives the text of a scene by name.
pub fn accuracy<'s>(
    catalogue: &Catalogue,
    scene: &dyn Fn(&str) -> Option<&'s str>,
    setup: &mut Setup<'_>,
    journal: &mut Journal,
) -> Vec<Row> {
    let cases: Vec<&Case> = catalogue.case.iter().filter(|c| setup.wants(&c.name)).collect();
    let all: usize = cases.iter().map(|c| runs(c, setup.quick).count()).sum();
    let (mut done, mut rows) = (0, Vec::new());
    for case in cases {
        let mut of_case = Vec::new();
        for (method, level, dt) in runs(case, setup.quick).collect::<Vec<_>>() {
            if (setup.stopped)() {
                return rows;
            }
            (setup.progress)(done, all, &format!("{}, {}, n = {}", case.name, method.name, case.level[level].n));
            done += 1;
            let blank = blank(case, method, level, dt, setup.threads);
            let row = match journal.get(&blank.key()) {
                Some(row) => row,
                None => {
                    let row = run(case, method, (level, dt), blank, scene, setup);
                    journal.put(&row);
                    row
                }
            };
            of_case.push(row);
        }
        judge(case, &mut of_case);
        rows.extend(of_case);
    }
    rows
}

/// Methods, places of levels, and steps, finest last.
fn runs(case: &Case, quick: bool) -> impl Iterator<Item = (&Method, usize, f64)> {
    let few = |count: usize, over: Over| if quick && case.over == over { count.min(case.quick) } else { count };
    let levels = few(case.level.len(), Over::N);
    let steps = few(case.step.len(), Over::Dt);
    let methods = case.method.iter().filter(move |m| !(quick && m.slow));
    methods.flat_map(move |m| (0..levels).flat_map(move |l| case.step[..steps].iter().map(move |dt| (m, l, *dt))))
}

fn blank(case: &Case, method: &Method, level: usize, dt: f64, threads: usize) -> Row {
    Row {
        case: case.name.clone(),
        method: method.name.clone(),
        n: case.level[level].n,
        dt: method.set.get("time.dt").and_then(toml::Value::as_float).unwrap_or(dt),
        threads,
        expected_order: method.order,
        ..Row::default()
    }
}

fn run<'s>(
    case: &Case,
    method: &Method,
    (level, dt): (usize, f64),
    mut row: Row,
    scene: &dyn Fn(&str) -> Option<&'s str>,
    setup: &mut Setup<'_>,
) -> Row {
    let mut set = settings([&case.level[level].set, &method.set]);
    if !method.set.contains_key("time.dt") {
        set.push(("time.dt".to_owned(), dt.to_string()));
    }
    let Some(text) = scene(&case.scene) else {
        row.note = format!("no scene `{}`", case.scene);
        row.passed = Some(false);
        return row;
    };
    let path = Path::new(&case.scene).with_extension("toml");
    let trial = Trial { path: &path, text, set, threads: setup.threads, search: &setup.search, clock: setup.clock };
    let measures: Vec<&Measure> = case.measure.iter().map(|w| &w.measure).collect();
    let outcome = match trial.run(&measures, |_| !(setup.stopped)()) {
        Ok(outcome) => outcome,
        Err(error) => {
            row.note = error.to_string();
            row.passed = Some(false);
            return row;
        }
    };
    setup.ran(&outcome);
    let mut worst = 0.0_f64;
    for (i, (wanted, value)) in case.measure.iter().zip(&outcome.values).enumerate() {
        let expected = method.expected.as_ref().map_or(wanted.expected, |e| e[i]);
        let off = (value - expected).abs() / wanted.scale.unwrap_or(expected).abs();
        // A value that is not a number is the worst there is.
        worst = if off.is_nan() { f64::INFINITY } else { worst.max(off) };
        row.found.insert(if i == 0 { "value".into() } else { format!("value {}", i + 1) }, *value);
    }
    row.error = (worst.is_finite() && outcome.frozen.is_none()).then_some(worst);
    (row.wall_seconds, row.cpu_seconds, row.open_seconds) = (outcome.wall, outcome.cpu, outcome.open);
    (row.bytes, row.iterations) = (outcome.bytes, outcome.iterations);
    row.note = outcome.frozen.unwrap_or_default();
    if outcome.unconverged > 0 {
        row.note += &format!("{} solves not converged, residual {:.1e}; ", outcome.unconverged, outcome.residual);
    }
    row
}

/// Orders, verdicts and the front, once all runs of a case are there.
fn judge(case: &Case, rows: &mut [Row]) {
    let size = |row: &Row| if case.over == Over::N { 1.0 / row.n as f64 } else { row.dt };
    let stated = if case.over == Over::N { 1.0 / case.at } else { case.at };
    for i in 0..rows.len() {
        let method = case.method.iter().find(|m| m.name == rows[i].method);
        let tolerance = method.and_then(|m| m.tolerance).unwrap_or(case.tolerance);
        let before = (0..i).rev().find(|&j| rows[j].method == rows[i].method && same_line(case, &rows[j], &rows[i]));
        let later =
            (i + 1..rows.len()).any(|j| rows[j].method == rows[i].method && same_line(case, &rows[j], &rows[i]));
        let coarser = (size(&rows[i]) / stated).max(1.0);
        let allowed = tolerance * coarser.powf(rows[i].expected_order.unwrap_or(0.0));
        rows[i].tolerance = Some(allowed);
        let error = rows[i].error;
        rows[i].order = before.and_then(|j| {
            let errors = (rows[j].error?, error?);
            (errors.1 > case.floor).then(|| order((size(&rows[j]), errors.0), (size(&rows[i]), errors.1)))?
        });
        let slow = match (rows[i].order, rows[i].expected_order) {
            (Some(found), Some(expected)) if !later => found < expected - ORDER_SLACK,
            _ => false,
        };
        if slow {
            rows[i].note += "its order is too low; ";
        }
        if error.is_some_and(|e| e > allowed) {
            rows[i].note += "its error is over the tolerance; ";
        }
        rows[i].passed = Some(error.is_some_and(|e| e <= allowed) && !slow);
    }
    let points: Vec<_> = rows.iter().map(|r| (r.wall_seconds, r.error.unwrap_or(f64::NAN))).collect();
    for (row, on) in rows.iter_mut().zip(front(&points)) {
        row.front = on;
    }
}

/// Whether two rows differ in nothing but what is refined.
fn same_line(case: &Case, a: &Row, b: &Row) -> bool {
    if case.over == Over::N { a.dt == b.dt } else { a.n == b.n }
}
