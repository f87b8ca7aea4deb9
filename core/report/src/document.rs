//! A complete report.

use crate::catalogue::NotRun;
use crate::clock::{ClockCheck, ClockWatch};
use crate::context::ReportContext;
use crate::row::Row;
use crate::section::Section;
use pliant_record::Machine;
use serde::Serialize;
use std::collections::BTreeSet;

/// The kinds of reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ReportKind {
    /// Error against run time, of cases with known answers.
    Accuracy,
    /// Step limits, energy balances, extremes and the coupling of a hand.
    Stability,
    /// Time of a step against size, threads and contacts.
    Performance,
}

impl ReportKind {
    /// Name in commands and file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Accuracy => "accuracy",
            Self::Stability => "stability",
            Self::Performance => "performance",
        }
    }
}

/// Whether the rows of a report meet their criteria.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// Number of rows that have a criterion.
    pub judged: usize,
    /// Number of rows that meet it.
    pub passed: usize,
    /// A description of each failed row, and of a clock that failed its check.
    #[serde(rename = "missed")]
    pub failed: Vec<String>,
    /// Whether all rows meet their criteria and the clock passed its check.
    pub good: bool,
}

/// Measurements of a report: rows, their presentation, and cases that were not run.
#[derive(Clone, Debug, Default)]
pub struct Measurements {
    /// Rows in the order of the catalogue.
    pub rows: Vec<Row>,
    /// Presentation of the rows.
    pub sections: Vec<Section>,
    /// Cases that were not run.
    pub not_run: Vec<NotRun>,
}

/// A complete report.
#[derive(Clone, Debug, Serialize)]
pub struct Document {
    /// Kind of the report.
    pub report: ReportKind,
    /// Program, version and build that made it.
    pub program: String,
    /// Arguments of the command.
    pub settings: Vec<String>,
    /// Seed of the order in which timed runs are interleaved. The runs themselves draw no random numbers that depend on it.
    pub seed: u64,
    /// Whether it is a quick report, with fewer resolutions.
    pub quick: bool,
    /// Whether the report was stopped before its end.
    pub interrupted: bool,
    /// Number of threads of a run, unless a row has its own.
    pub threads: usize,
    /// Plugins that were opened, with their versions.
    pub plugins: BTreeSet<String>,
    /// Machine of the measurement.
    pub machine: Machine,
    /// Result of the clock check.
    pub clock: ClockCheck,
    /// Whether the rows meet their criteria.
    pub verdict: Verdict,
    /// Rows in the order of the catalogue.
    pub rows: Vec<Row>,
    /// Cases that were not run, and why.
    pub not_run: Vec<NotRun>,
    /// The rows as people read them.
    #[serde(skip)]
    pub sections: Vec<Section>,
}

/// Build profile; durations of a development build are not representative.
const BUILD: &str = if cfg!(debug_assertions) { ", development build" } else { ", release build" };

/// A report in progress.
pub struct ReportBuilder {
    machine: Machine,
    watch: ClockWatch,
}

impl ReportBuilder {
    /// Records the machine and its load, and starts the clock check.
    pub fn start(context: &ReportContext<'_>) -> Self {
        Self { machine: Machine::current(), watch: ClockWatch::start(context.options.clock) }
    }

    /// Builds the report from its measurements. `settings` are the arguments of the command.
    pub fn finish(
        self,
        kind: ReportKind,
        context: &ReportContext<'_>,
        settings: Vec<String>,
        measurements: Measurements,
    ) -> Document {
        let Measurements { rows, sections, not_run } = measurements;
        let options = &context.options;
        let clock = self.watch.check(context.busy());
        let mut failed: Vec<String> = rows.iter().filter(|r| r.failed()).map(describe_miss).collect();
        if !clock.passed {
            let (wall, calendar, share) = (clock.wall_seconds, clock.calendar_seconds, clock.cpu_share);
            failed.push(format!(
                "the clock cannot be trusted: {wall:.3} s by the clock, {calendar:.3} s by the calendar, CPU share {share:.2}"
            ));
        }
        let judged = rows.iter().filter(|r| r.passed.is_some()).count();
        let passed = rows.iter().filter(|r| r.passed == Some(true)).count();
        let verdict = Verdict { judged, passed, good: failed.is_empty(), failed };
        Document {
            report: kind,
            program: format!("pliant {}{}", env!("CARGO_PKG_VERSION"), BUILD),
            settings,
            seed: options.seed,
            quick: options.quick,
            interrupted: context.is_stopped(),
            threads: options.threads,
            plugins: context.plugins().clone(),
            machine: self.machine,
            clock,
            verdict,
            rows,
            not_run,
            sections,
        }
    }
}

/// Description of a row that failed its criterion.
fn describe_miss(row: &Row) -> String {
    let parameters: Vec<String> = row.parameters.iter().map(|(name, value)| format!(", {name} {value:.3e}")).collect();
    let mut text = format!("{}, {}, n = {}, dt = {:e} s{}", row.case, row.method, row.n, row.dt, parameters.concat());
    if let (Some(error), Some(tolerance)) = (row.error, row.tolerance) {
        text += &format!(": error {error:.2e}, allowed {tolerance:.2e}");
    }
    if let (Some(order), Some(expected)) = (row.order, row.expected_order) {
        text += &format!(", order {order:.2} of {expected}");
    }
    if row.note.is_empty() { text } else { format!("{text}: {}", row.note) }
}
