//! One case of a performance report and its repeated runs.

use super::catalogue::{LeftOutPair, Sweep};
use crate::context::ReportContext;
use crate::fit::{median, percentile, relative_range};
use crate::row::Row;
use crate::scene_run::{RunResult, SceneRun, SceneSource};
use crate::settings::{Setting, Settings, merge};
use pliant_mesh::geometry::Vec3;
use pliant_record::Machine;
use std::path::Path;

/// Fraction of a run's steps that are warm-up and not timed.
const WARM_UP: f64 = 0.2;

/// Stages of a step, in the order of [`RunResult::stage_seconds`].
pub(super) const STAGES: [&str; 3] = ["regions", "contact", "integration"];

/// A case that is timed.
pub(super) struct TimedCase<'a> {
    /// The row with all settings, and a note on a failed run.
    pub(super) row: Row,
    /// Name of the scene.
    scene: &'a str,
    settings: Vec<Setting>,
    repeats: Vec<Repeat>,
}

/// One run of a case.
struct Repeat {
    result: RunResult,
    /// Number of nodes held by tools at the end.
    contacts: f64,
}

impl<'a> TimedCase<'a> {
    /// A case without runs.
    fn new(row: Row, scene: &'a str, settings: [&Settings; 2]) -> Self {
        Self { row, scene, settings: merge(settings), repeats: Vec::new() }
    }

    /// A case for each point and number of threads of a sweep that this machine has.
    pub(super) fn of_sweep(sweep: &'a Sweep, quick: bool) -> Vec<Self> {
        let points = if quick { sweep.quick_points.min(sweep.points.len()) } else { sweep.points.len() };
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let mut cases = Vec::new();
        for point in &sweep.points[..points] {
            for threads in sweep.threads.iter().copied().filter(|t| *t <= processors) {
                let (case, method) = (sweep.name.clone(), sweep.method.clone());
                let mut row = Row { case, method, n: point.n, threads, ..Row::default() };
                row.parameters.extend(point.parameters.clone());
                cases.push(Self::new(row, &sweep.scene, [&sweep.settings, &point.settings]));
            }
        }
        cases
    }

    /// The case without the part, and with it.
    pub(super) fn of_pair(pair: &'a LeftOutPair, threads: usize) -> Vec<Self> {
        let row = |method: &str| Row { case: pair.case(), method: method.into(), threads, ..Row::default() };
        vec![
            Self::new(row("as it is"), &pair.scene, [&pair.settings, &Settings::new()]),
            Self::new(row("with it"), &pair.scene, [&pair.settings, &pair.with_part]),
        ]
    }

    /// Runs the case once more.
    pub(super) fn repeat(&mut self, scenes: SceneSource<'_>, context: &mut ReportContext<'_>) {
        let Some(text) = scenes(self.scene) else {
            self.row.note = format!("no scene `{}`", self.scene);
            return;
        };
        let (settings, threads) = (self.settings.clone(), self.row.threads);
        let (path, search, clock) = (Path::new(self.scene), &context.options.search, context.options.clock);
        let (mut contacts, mut constraints) = (0, Vec::new());
        let run = SceneRun { path, text, settings, threads, search, clock, stop: context.stop() }.run(&[], |session| {
            if session.steps() == 1 {
                // No tool is in contact yet, so all constrained nodes are fixings of the scene.
                constraints = session.bodies.iter().map(|b| b.system.nodes.constraint.clone()).collect();
            }
            contacts = 0;
            for (index, of_body) in constraints.iter().enumerate() {
                let held = session.reactions(index).iter().zip(of_body);
                contacts += held.filter(|(f, constraint)| **f != Vec3::zeros() && constraint.is_free()).count();
            }
            true
        });
        match run {
            Ok(result) => {
                context.add_run(&result);
                self.repeats.push(Repeat { result, contacts: contacts as f64 });
            }
            Err(error) => self.row.note = error.to_string(),
        }
    }

    /// The row of all repeats.
    pub(super) fn summarize(self) -> Row {
        let Self { mut row, repeats, .. } = self;
        let Some(Repeat { result: first, contacts }) = repeats.first() else {
            row.passed = Some(false);
            return row;
        };
        let warm = (WARM_UP * first.step_seconds.len() as f64).ceil() as usize;
        let timed = |r: &Repeat| r.result.step_seconds[warm.min(r.result.step_seconds.len() - 1)..].to_vec();
        let medians: Vec<f64> = repeats.iter().map(|r| median(&timed(r))).collect();
        let pooled: Vec<f64> = repeats.iter().flat_map(timed).collect();
        let step_seconds = median(&medians);
        row.step_seconds_median = Some(step_seconds);
        row.step_seconds_p99 = Some(percentile(&pooled, 0.99));
        row.spread = Some(relative_range(&medians));
        let median_of =
            |pick: &dyn Fn(&RunResult) -> f64| median(&repeats.iter().map(|r| pick(&r.result)).collect::<Vec<_>>());
        row.wall_seconds = median_of(&|r| r.wall);
        row.cpu_seconds = median_of(&|r| r.cpu);
        row.open_seconds = median_of(&|r| r.open);
        (row.dt, row.bytes, row.iterations) = (first.dt, first.bytes, first.iterations);
        for (i, stage) in STAGES.iter().enumerate() {
            let stages = repeats.iter().flat_map(|r| {
                let all = &r.result.stage_seconds;
                all[warm.min(all.len() - 1)..].iter().map(|stages| stages[i])
            });
            row.results.insert(format!("{stage} (s)"), median(&stages.collect::<Vec<_>>()));
        }
        let (nodes, steps) = (first.nodes as f64, first.step_seconds.len() as f64);
        let iterations = first.iterations as f64 / steps;
        let operations = model_operations(nodes, *contacts, iterations);
        row.results.extend([
            ("nodes".to_owned(), nodes),
            ("contacts".to_owned(), *contacts),
            ("iterations a step".to_owned(), iterations),
            ("model (flop a step)".to_owned(), operations),
            ("model over time (flop/s)".to_owned(), operations / step_seconds),
            ("model (bytes)".to_owned(), MODEL_NUMBERS * size_of::<f64>() as f64 * nodes),
            ("wall a step (s)".to_owned(), row.wall_seconds / steps),
        ]);
        if let Some(peak) = Machine::peak_memory() {
            row.results.insert("peak of the program so far (bytes)".into(), peak as f64);
        }
        row
    }
}

/// Numbers kept for a node in the model of Tripicchio, D'Avella and Ruffaldi (2022).
const MODEL_NUMBERS: f64 = 607.0;

/// Floating-point operations of a step in the model of Tripicchio, D'Avella and Ruffaldi (2022).
fn model_operations(nodes: f64, contacts: f64, iterations: f64) -> f64 {
    7940.0 * nodes + 36.0 * contacts + (156.0 * nodes + 36.0 * contacts) * iterations
}
