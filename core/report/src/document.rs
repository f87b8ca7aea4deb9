//! A report as a whole.

use super::catalogue::NotRun;
use super::clock::{ClockCheck, Watch};
use super::page::Section;
use super::{Row, Setup};
use pliant_record::Machine;
use serde::Serialize;
use std::collections::BTreeSet;

/// Reports there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Error against run time.
    Accuracy,
    /// What holds, and up to where.
    Stability,
    /// What a step costs.
    Performance,
}

impl Kind {
    /// As the command says it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Accuracy => "accuracy",
            Self::Stability => "stability",
            Self::Performance => "performance",
        }
    }
}

/// What a report comes to.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// Rows that had something to meet.
    pub judged: usize,
    /// Of them, those that met it.
    pub passed: usize,
    /// Each that did not, in a sentence.
    pub missed: Vec<String>,
    /// Whether all did, and the clock can be believed.
    pub good: bool,
}

/// Everything a report says.
#[derive(Clone, Debug, Serialize)]
pub struct Document {
    /// Which.
    pub report: Kind,
    /// The program that made it.
    pub program: String,
    /// As it was asked for.
    pub settings: Vec<String>,
    /// Of the order in which timed runs are interleaved; the runs themselves draw no random numbers but from a fixed start.
    pub seed: u64,
    /// Fewer resolutions, within a minute.
    pub quick: bool,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
    /// Threads of a run, where no row says otherwise.
    pub threads: usize,
    /// Plugins that were opened, with their versions.
    pub plugins: BTreeSet<String>,
    /// Where it was measured.
    pub machine: Machine,
    /// Whether the clock can be believed.
    pub clock: ClockCheck,
    /// What it comes to.
    pub verdict: Verdict,
    /// The measurements.
    pub rows: Vec<Row>,
    /// What is not in it, and why.
    pub not_run: Vec<NotRun>,
    /// As people read it.
    #[serde(skip)]
    pub sections: Vec<Section>,
}

/// Durations of a development build say little about those of a released one.
const BUILD: &str = if cfg!(debug_assertions) { ", development build" } else { ", release build" };

/// A report under way.
pub struct Opened {
    machine: Machine,
    watch: Watch,
}

impl Opened {
    /// Looks at the machine, and starts the clock's check.
    pub fn start(setup: &Setup<'_>) -> Self {
        Self { machine: Machine::current(), watch: Watch::start(setup.clock) }
    }

    /// Puts it together.
    pub fn finish(self, kind: Kind, setup: &Setup<'_>, settings: Vec<String>, rows: Vec<Row>) -> Document {
        let clock = self.watch.check(setup.spent);
        let mut missed: Vec<String> = rows.iter().filter(|r| r.missed()).map(sentence).collect();
        if !clock.passed {
            let (wall, calendar, share) = (clock.wall_seconds, clock.calendar_seconds, clock.cpu_share);
            missed.push(format!(
                "the clock cannot be believed: {wall:.3} s by it were {calendar:.3} s by the calendar, CPU share {share:.2}"
            ));
        }
        let judged = rows.iter().filter(|r| r.passed.is_some()).count();
        let passed = rows.iter().filter(|r| r.passed == Some(true)).count();
        let verdict = Verdict { judged, passed, good: missed.is_empty(), missed };
        Document {
            report: kind,
            program: format!("pliant {}{}", env!("CARGO_PKG_VERSION"), BUILD),
            settings,
            seed: setup.seed,
            quick: setup.quick,
            interrupted: (setup.stopped)(),
            threads: setup.threads,
            plugins: setup.plugins.clone(),
            machine: self.machine,
            clock,
            verdict,
            rows,
            not_run: Vec::new(),
            sections: Vec::new(),
        }
    }
}

/// A miss, as a person reads it.
fn sentence(row: &Row) -> String {
    let at: Vec<String> = row.at.iter().map(|(name, value)| format!(", {name} {value:.3e}")).collect();
    let mut text = format!("{}, {}, n = {}, dt = {:e} s{}", row.case, row.method, row.n, row.dt, at.concat());
    if let (Some(error), Some(tolerance)) = (row.error, row.tolerance) {
        text += &format!(": error {error:.2e}, allowed {tolerance:.2e}");
    }
    if let (Some(order), Some(expected)) = (row.order, row.expected_order) {
        text += &format!(", order {order:.2} of {expected}");
    }
    let note = row.note.trim_end_matches([';', ' ']);
    if note.is_empty() { text } else { format!("{text}: {note}") }
}
