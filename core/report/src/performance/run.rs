//! Runs a performance catalogue.
//!
//! Every run has a warm-up. Compared runs are interleaved, in a new random order for each repetition, so that background load affects all of them alike. Step
//! times are given by median and 99th percentile, repetitions by the range of their medians.

use super::catalogue::PerformanceCatalogue;
use super::haptic_loop::haptic_loop;
use super::page::performance_sections;
use super::start_up::start_up;
use super::timed_case::TimedCase;
use crate::context::ReportContext;
use crate::document::Measurements;
use crate::fit::exponent;
use crate::journal::Journal;
use crate::row::Row;
use crate::scene_run::SceneSource;
use std::path::Path;

/// Largest difference by which the exponent of the cost may exceed the expected one.
const GROWTH_SLACK: f64 = 0.3;
/// Number of repetitions of a case, in full and in quick reports.
const REPEATS: (usize, usize) = (5, 2);

/// Runs every wanted case of a catalogue, and times the start of `program` if it is given.
pub fn performance(
    catalogue: &PerformanceCatalogue,
    scenes: SceneSource<'_>,
    program: Option<&Path>,
    context: &mut ReportContext<'_>,
    journal: &mut Journal,
) -> Measurements {
    let mut rows = Vec::new();
    run_all(catalogue, scenes, context, journal, &mut rows);
    if context.wants("start-up") {
        rows.extend(program.map(|program| start_up(program, context)));
    }
    let sections = performance_sections(&catalogue.sweeps, &rows);
    Measurements { rows, sections, not_run: catalogue.not_run.clone() }
}

/// Adds the rows of all cases, or of those before the report was stopped.
fn run_all(
    catalogue: &PerformanceCatalogue,
    scenes: SceneSource<'_>,
    context: &mut ReportContext<'_>,
    journal: &mut Journal,
    rows: &mut Vec<Row>,
) {
    let (quick, threads) = (context.options.quick, context.options.threads);
    let mut groups: Vec<Vec<TimedCase<'_>>> =
        catalogue.sweeps.iter().map(|sweep| TimedCase::of_sweep(sweep, quick)).collect();
    groups.extend(catalogue.pairs.iter().map(|pair| TimedCase::of_pair(pair, threads)));
    groups.iter_mut().for_each(|group| group.retain(|case| context.wants(&case.row.case)));
    let repeats = if quick { REPEATS.1 } else { REPEATS.0 };
    let total: usize = groups.iter().map(|group| repeats * group.len()).sum();
    let (mut done, mut shuffle) = (0, Shuffle(context.options.seed));
    for mut group in groups {
        let old: Option<Vec<Row>> = group.iter().map(|case| journal.get(&case.row.key())).collect();
        if let Some(old) = old.filter(|old| !old.is_empty()) {
            done += repeats * old.len();
            rows.extend(old);
            continue;
        }
        for _ in 0..repeats {
            for i in shuffle.order(group.len()) {
                if context.is_stopped() {
                    return;
                }
                let row = &group[i].row;
                context.announce(done, total, &format!("{}, {}, n = {}", row.case, row.method, row.n));
                done += 1;
                group[i].repeat(scenes, context);
            }
        }
        if context.is_stopped() {
            return;
        }
        for case in group {
            let row = case.summarize();
            journal.put(&row);
            rows.push(row);
        }
    }
    rows.extend(growth_rows(catalogue, rows));
    let loops = if context.wants("haptic-loop") { &catalogue.haptic_loops[..] } else { &[] };
    for case in loops {
        context.announce(done, total, &format!("haptic-loop, {}", case.name));
        rows.push(haptic_loop(case, scenes, context));
    }
}

/// Exponents of the time of a step over the number of nodes, a row for each sweep of sizes and number of threads.
fn growth_rows(catalogue: &PerformanceCatalogue, rows: &[Row]) -> Vec<Row> {
    let mut out = Vec::new();
    for sweep in catalogue.sweeps.iter().filter(|s| s.growth.is_some()) {
        for &threads in &sweep.threads {
            let of = rows.iter().filter(|r| r.case == sweep.name && r.threads == threads);
            let points: Vec<(f64, f64)> =
                of.filter_map(|r| Some((*r.results.get("nodes")?, r.step_seconds_median?))).collect();
            let Some(order) = exponent(&points) else { continue };
            out.push(Row {
                case: format!("growth: {}", sweep.name),
                method: sweep.method.clone(),
                threads,
                order: Some(order),
                expected_order: sweep.growth,
                passed: sweep.growth.map(|expected| order <= expected + GROWTH_SLACK),
                note: "exponent of the time of a step over the number of nodes".into(),
                ..Row::default()
            });
        }
    }
    out
}

/// Draws orders with a linear congruential generator (constants of Knuth's MMIX).
struct Shuffle(u64);

impl Shuffle {
    /// The numbers below `count` in a random order (Fisher and Yates).
    fn order(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for i in (1..count).rev() {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            order.swap(i, (self.0 >> 33) as usize % (i + 1));
        }
        order
    }
}
