//! Runs the cases of an accuracy catalogue and evaluates their rows.

use super::catalogue::{AccuracyCase, AccuracyCatalogue, Level, Method, Refinement};
use super::page::accuracy_sections;
use crate::context::ReportContext;
use crate::document::Measurements;
use crate::fit::{ErrorAt, order, pareto_front};
use crate::journal::Journal;
use crate::measure::Measure;
use crate::row::Row;
use crate::scene_run::{SceneRun, SceneSource};
use crate::settings::{merge, setting};
use pliant_engine::session::Session;
use std::path::Path;

/// An observed order may fall short of the expected one by this much: the coarser run of a pair may be outside the asymptotic range.
const ORDER_SLACK: f64 = 0.3;

/// One run: a case, a method, a mesh level and a step size.
#[derive(Clone, Copy)]
struct CaseRun<'a> {
    case: &'a AccuracyCase,
    method: &'a Method,
    level: &'a Level,
    /// Step size unless the method sets `time.dt`, s.
    dt: f64,
}

/// Runs every wanted case of a catalogue with every method at every resolution.
pub fn accuracy(
    catalogue: &AccuracyCatalogue,
    scenes: SceneSource<'_>,
    context: &mut ReportContext<'_>,
    journal: &mut Journal,
) -> Measurements {
    let rows = run_all(catalogue, scenes, context, journal);
    let sections = accuracy_sections(&catalogue.cases, &rows);
    Measurements { rows, sections, not_run: catalogue.not_run.clone() }
}

/// Rows of all cases that finished before the report was stopped.
fn run_all(
    catalogue: &AccuracyCatalogue,
    scenes: SceneSource<'_>,
    context: &mut ReportContext<'_>,
    journal: &mut Journal,
) -> Vec<Row> {
    let cases: Vec<&AccuracyCase> = catalogue.cases.iter().filter(|c| context.wants(&c.name)).collect();
    let total: usize = cases.iter().map(|c| runs_of(c, context.options.quick).len()).sum();
    let (mut done, mut rows) = (0, Vec::new());
    for case in cases {
        let mut case_rows = Vec::new();
        for run in runs_of(case, context.options.quick) {
            if context.is_stopped() {
                return rows;
            }
            context.announce(done, total, &format!("{}, {}, n = {}", case.name, run.method.name, run.level.n));
            done += 1;
            let row = run.empty_row(context.options.threads);
            let cached = journal.get(&row.key());
            let is_cached = cached.is_some();
            let row = cached.unwrap_or_else(|| run.measure(row, scenes, context));
            if context.is_stopped() {
                return rows;
            }
            if !is_cached {
                journal.put(&row);
            }
            case_rows.push(row);
        }
        evaluate(case, &mut case_rows);
        rows.extend(case_rows);
    }
    rows
}

/// All runs of a case, by method, level and step, finest last.
fn runs_of(case: &AccuracyCase, quick: bool) -> Vec<CaseRun<'_>> {
    let limit = |count: usize, refinement: Refinement| {
        if quick && case.refinement == refinement { count.min(case.quick_resolutions) } else { count }
    };
    let levels = &case.levels[..limit(case.levels.len(), Refinement::Space)];
    let steps = &case.steps[..limit(case.steps.len(), Refinement::Time)];
    let mut runs = Vec::new();
    for method in case.methods.iter().filter(|m| !(quick && m.slow)) {
        for level in levels {
            runs.extend(steps.iter().map(|dt| CaseRun { case, method, level, dt: *dt }));
        }
    }
    runs
}

impl CaseRun<'_> {
    /// The row with all settings and no measurements.
    fn empty_row(&self, threads: usize) -> Row {
        Row {
            case: self.case.name.clone(),
            method: self.method.name.clone(),
            n: self.level.n,
            dt: self.method.settings.get("time.dt").and_then(toml::Value::as_float).unwrap_or(self.dt),
            threads,
            expected_order: self.method.order,
            ..Row::default()
        }
    }

    /// Runs the scene and fills in the largest relative error and the cost.
    fn measure(&self, mut row: Row, scenes: SceneSource<'_>, context: &mut ReportContext<'_>) -> Row {
        let Self { case, method, level, dt } = *self;
        let mut settings = merge([&level.settings, &method.settings]);
        if !method.settings.contains_key("time.dt") {
            settings.push(setting("time.dt", dt));
        }
        let Some(text) = scenes(&case.scene) else { return row.with_failure(format!("no scene `{}`", case.scene)) };
        let path = Path::new(&case.scene).with_extension("toml");
        let (threads, search, clock) = (context.options.threads, &context.options.search, context.options.clock);
        let run = SceneRun { path: &path, text, settings, threads, search, clock, stop: context.stop() };
        let measures: Vec<&Measure> = case.measures.iter().map(|expected| &expected.measure).collect();
        let run_to_the_end = |_: &mut Session| true;
        let result = match run.run(&measures, run_to_the_end) {
            Ok(result) => result,
            Err(error) => return row.with_failure(error.to_string()),
        };
        context.add_run(&result);
        let mut largest = 0.0_f64;
        for (i, (measure, value)) in case.measures.iter().zip(&result.values).enumerate() {
            let expected = method.expected.as_ref().map_or(measure.expected, |values| values[i]);
            let error = (value - expected).abs() / measure.scale.unwrap_or(expected).abs();
            // NaN is worse than any error.
            largest = if error.is_nan() { f64::INFINITY } else { largest.max(error) };
            row.results.insert(if i == 0 { "value".into() } else { format!("value {}", i + 1) }, *value);
        }
        row.error = (largest.is_finite() && result.frozen.is_none()).then_some(largest);
        row.set_cost(&result);
        if let Some(frozen) = result.frozen {
            row.add_note(&frozen);
        }
        if result.unconverged > 0 {
            row.add_note(&format!("{} solves not converged, residual {:.1e}", result.unconverged, result.residual));
        }
        row
    }
}

/// Fills in orders, tolerances, verdicts and the Pareto front, after all runs of a case have finished.
fn evaluate(case: &AccuracyCase, rows: &mut [Row]) {
    let (discretization_size, tolerance_at): (fn(&Row) -> f64, f64) = match case.refinement {
        Refinement::Space => (|row| 1.0 / row.n as f64, 1.0 / case.tolerance_at),
        Refinement::Time => (|row| row.dt, case.tolerance_at),
    };
    for i in 0..rows.len() {
        let method = case.methods.iter().find(|m| m.name == rows[i].method);
        let tolerance = method.and_then(|m| m.tolerance).unwrap_or(case.tolerance);
        let coarser_index = (0..i).rev().find(|&j| same_series(case, &rows[j], &rows[i]));
        let is_finest = !(i + 1..rows.len()).any(|j| same_series(case, &rows[j], &rows[i]));
        let refinement_ratio = (discretization_size(&rows[i]) / tolerance_at).max(1.0);
        // The allowed error grows as (h / h_ref)^p.
        let allowed = tolerance * refinement_ratio.powf(rows[i].expected_order.unwrap_or(0.0));
        rows[i].tolerance = Some(allowed);
        let error = rows[i].error;
        rows[i].order = coarser_index.and_then(|j| {
            let coarse = ErrorAt { size: discretization_size(&rows[j]), error: rows[j].error? };
            let fine = ErrorAt { size: discretization_size(&rows[i]), error: error? };
            if fine.error > case.floor { order(coarse, fine) } else { None }
        });
        let order_too_low = match (rows[i].order, rows[i].expected_order) {
            (Some(observed), Some(expected)) if is_finest => {
                let least = expected - ORDER_SLACK;
                let too_low = observed < least;
                if too_low {
                    rows[i].add_note(&format!("the order is below {least:.2}"));
                }
                too_low
            }
            _ => false,
        };
        if error.is_some_and(|e| e > allowed) {
            rows[i].add_note("the error exceeds the tolerance");
        }
        rows[i].passed = Some(error.is_some_and(|e| e <= allowed) && !order_too_low);
    }
    let points: Vec<_> = rows.iter().map(|r| (r.wall_seconds, r.error.unwrap_or(f64::NAN))).collect();
    for (row, on_front) in rows.iter_mut().zip(pareto_front(&points)) {
        row.on_front = on_front;
    }
}

/// Whether two rows belong to the same refinement series.
fn same_series(case: &AccuracyCase, a: &Row, b: &Row) -> bool {
    a.method == b.method
        && match case.refinement {
            Refinement::Space => a.dt == b.dt,
            Refinement::Time => a.n == b.n,
        }
}
