//! What a step costs: against size, threads, contacts and stage, beside what a model says; and what leaving out saves.
//!
//! Every run warms up first. Runs that are compared are repeated in turn, in an order drawn anew each time, so that whatever
//! else the machine does falls on all of them alike. Steps are given by their median and 99th percentile, repeats by the spread
//! of their medians.

mod catalogue;
mod live;
mod page;

pub use catalogue::{Haptic, Pair, PerformanceCatalogue, Place, Sweep};
pub use page::performance_page;

use super::catalogue::{Settings, settings};
use super::{Journal, Outcome, Row, Setup, Trial, exponent, median, percentile};
use pliant_record::Machine;
use std::path::Path;

/// Share of a run's steps that only warm it up.
const WARM: f64 = 0.2;
/// By how much cost may grow faster than expected, as an exponent.
const GROWTH_SLACK: f64 = 0.3;

/// One thing that is timed.
struct Timed<'a> {
    row: Row,
    scene: &'a str,
    set: Vec<(String, String)>,
    /// Each repeat.
    runs: Vec<(Outcome, f64)>,
}

/// Runs all of it.
pub fn performance(
    catalogue: &PerformanceCatalogue,
    scenes: super::stability::Scenes<'_>,
    setup: &mut Setup<'_>,
    journal: &mut Journal,
) -> Vec<Row> {
    let mut groups: Vec<Vec<Timed<'_>>> = catalogue.sweep.iter().map(|s| sweep(s, setup)).collect();
    groups.extend(catalogue.pair.iter().map(|p| pair(p, setup)));
    groups.iter_mut().for_each(|g| g.retain(|t| setup.wants(&t.row.case)));
    let repeats = if setup.quick { 2 } else { 5 };
    let all: usize = groups.iter().map(|g| repeats * g.len()).sum();
    let (mut done, mut rows, mut draw) = (0, Vec::new(), Draw(setup.seed));
    for mut group in groups {
        let old: Option<Vec<Row>> = group.iter().map(|t| journal.get(&t.row.key())).collect();
        if let Some(old) = old.filter(|old| !old.is_empty()) {
            done += repeats * old.len();
            rows.extend(old);
            continue;
        }
        for _ in 0..repeats {
            for i in draw.order(group.len()) {
                if (setup.stopped)() {
                    return rows;
                }
                (setup.progress)(
                    done,
                    all,
                    &format!("{}, {}, n = {}", group[i].row.case, group[i].row.method, group[i].row.n),
                );
                done += 1;
                time(&mut group[i], scenes, setup);
            }
        }
        for timed in group {
            let row = settle(timed);
            journal.put(&row);
            rows.push(row);
        }
    }
    rows.extend(growth(catalogue, &rows));
    let loops = if setup.wants("haptic-loop") { &catalogue.haptic[..] } else { &[] };
    for haptic in loops {
        (setup.progress)(done, all, &format!("haptic-loop, {}", haptic.name));
        rows.push(live::live(haptic, scenes, setup));
    }
    rows
}

fn sweep<'a>(sweep: &'a Sweep, setup: &Setup<'_>) -> Vec<Timed<'a>> {
    let few = |all: usize| if setup.quick { sweep.quick.min(all) } else { all };
    let mut out = Vec::new();
    for place in &sweep.place[..few(sweep.place.len())] {
        for threads in sweep.threads.iter().copied().filter(|t| *t <= most_threads()) {
            let (case, method) = (sweep.name.clone(), sweep.method.clone());
            let mut row = Row { case, method, n: place.n, threads, ..Row::default() };
            row.at.extend(place.at.clone());
            out.push(timed(row, &sweep.scene, [&sweep.set, &place.set]));
        }
    }
    out
}

fn most_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn pair<'a>(pair: &'a Pair, setup: &Setup<'_>) -> Vec<Timed<'a>> {
    let row = |method: &str| Row {
        case: format!("left-out: {}", pair.name),
        method: method.into(),
        threads: setup.threads,
        ..Row::default()
    };
    vec![
        timed(row("as it is"), &pair.scene, [&pair.set, &Settings::new()]),
        timed(row("with it"), &pair.scene, [&pair.set, &pair.on]),
    ]
}

fn timed<'a>(row: Row, scene: &'a str, sets: [&Settings; 2]) -> Timed<'a> {
    Timed { row, scene, set: settings(sets), runs: Vec::new() }
}

fn time(timed: &mut Timed<'_>, scenes: super::stability::Scenes<'_>, setup: &mut Setup<'_>) {
    let Some(text) = scenes(timed.scene) else {
        timed.row.note = format!("no scene `{}`", timed.scene);
        return;
    };
    let (set, threads) = (timed.set.clone(), timed.row.threads);
    let trial = Trial { path: Path::new(timed.scene), text, set, threads, search: &setup.search, clock: setup.clock };
    let (mut contacts, mut fixed) = (0, Vec::new());
    let ran = trial.run(&[], |session| {
        if session.steps() == 1 {
            // Nothing touches yet: what is held now is held by the scene.
            fixed = session.bodies.iter().map(|b| b.system.nodes.constraint.clone()).collect();
        }
        contacts = 0;
        for (index, fixed) in fixed.iter().enumerate() {
            let held = session.reactions(index).iter().zip(fixed);
            contacts += held.filter(|(f, fixed)| **f != [0.0; 3] && fixed.is_free()).count();
        }
        true
    });
    match ran {
        Ok(outcome) => {
            setup.ran(&outcome);
            timed.runs.push((outcome, contacts as f64));
        }
        Err(error) => timed.row.note = error.to_string(),
    }
}

/// What the repeats come to.
fn settle(timed: Timed<'_>) -> Row {
    let Timed { mut row, runs, .. } = timed;
    let Some((first, contacts)) = runs.first() else {
        row.passed = Some(false);
        return row;
    };
    let warm = (WARM * first.steps.len() as f64).ceil() as usize;
    let late = |o: &Outcome| o.steps[warm.min(o.steps.len() - 1)..].to_vec();
    let medians: Vec<f64> = runs.iter().map(|(o, _)| median(&late(o))).collect();
    let pooled: Vec<f64> = runs.iter().flat_map(|(o, _)| late(o)).collect();
    let middle = median(&medians);
    row.step_seconds_median = Some(middle);
    row.step_seconds_p99 = Some(percentile(&pooled, 0.99));
    row.spread = Some((percentile(&medians, 1.0) - percentile(&medians, 0.0)) / middle);
    let of = |pick: &dyn Fn(&Outcome) -> f64| median(&runs.iter().map(|(o, _)| pick(o)).collect::<Vec<_>>());
    (row.wall_seconds, row.cpu_seconds, row.open_seconds) = (of(&|o| o.wall), of(&|o| o.cpu), of(&|o| o.open));
    (row.dt, row.bytes, row.iterations) = (first.dt, first.bytes, first.iterations);
    for (i, stage) in STAGES.iter().enumerate() {
        let parts: Vec<f64> =
            runs.iter().flat_map(|(o, _)| o.parts[warm.min(o.parts.len() - 1)..].iter().map(|p| p[i])).collect();
        row.found.insert(format!("{stage} (s)"), median(&parts));
    }
    let (nodes, steps) = (first.nodes as f64, first.steps.len() as f64);
    let iterations = first.iterations as f64 / steps;
    // Tripicchio, D'Avella and Ruffaldi (2022): operations of a step and numbers kept.
    let flops = 7940.0 * nodes + 36.0 * contacts + (156.0 * nodes + 36.0 * contacts) * iterations;
    row.found.extend([
        ("nodes".to_owned(), nodes),
        ("contacts".to_owned(), *contacts),
        ("iterations a step".to_owned(), iterations),
        ("model (flop a step)".to_owned(), flops),
        ("model over time (flop/s)".to_owned(), flops / middle),
        ("model (bytes)".to_owned(), 607.0 * 8.0 * nodes),
        ("wall a step (s)".to_owned(), row.wall_seconds / steps),
    ]);
    if let Some(peak) = Machine::peak_memory() {
        row.found.insert("peak of the program so far (bytes)".into(), peak as f64);
    }
    row
}

/// Stages of a step, in order.
const STAGES: [&str; 3] = ["regions", "contact", "integration"];

/// How cost grows with the number of nodes, one row a sweep and number of threads.
fn growth(catalogue: &PerformanceCatalogue, rows: &[Row]) -> Vec<Row> {
    let mut out = Vec::new();
    for sweep in catalogue.sweep.iter().filter(|s| s.growth.is_some()) {
        for &threads in &sweep.threads {
            let of = rows.iter().filter(|r| r.case == sweep.name && r.threads == threads);
            let points: Vec<(f64, f64)> =
                of.filter_map(|r| Some((*r.found.get("nodes")?, r.step_seconds_median?))).collect();
            let Some(order) = exponent(&points) else { continue };
            let expected_order = sweep.growth;
            out.push(Row {
                case: format!("growth: {}", sweep.name),
                method: sweep.method.clone(),
                threads,
                order: Some(order),
                expected_order,
                passed: expected_order.map(|e| order <= e + GROWTH_SLACK),
                note: "exponent of a step's seconds over the nodes".into(),
                ..Row::default()
            });
        }
    }
    out
}

/// Draws orders: a linear congruential generator (Knuth's MMIX constants).
struct Draw(u64);

impl Draw {
    fn order(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for i in (1..count).rev() {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            order.swap(i, (self.0 >> 33) as usize % (i + 1));
        }
        order
    }
}
