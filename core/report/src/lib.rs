//! Error against run time, stability and cost, measured: what `pliant report` computes.
//!
//! A case is a scene with something to measure in it and what should come out; a report runs cases, fits orders and growth,
//! and says plainly what missed. Nothing here knows a plugin: cases are handed in as texts.

mod accuracy;
mod accuracy_page;
mod baseline;
mod catalogue;
mod clock;
mod document;
mod fit;
mod journal;
mod measure;
mod own;
mod page;
mod performance;
mod plot;
mod row;
mod stability;
mod table;
mod trial;
mod write;

pub use accuracy::accuracy;
pub use accuracy_page::accuracy_page;
pub use baseline::{Regression, compare};
pub use catalogue::{Case, Catalogue, CatalogueError, Level, Method, NotRun, Over};
pub use clock::{Clock, ClockCheck};
pub use document::{Document, Kind, Opened, Verdict};
pub use fit::{exponent, front, median, order, percentile};
pub use journal::Journal;
pub use measure::{Measure, Quantity, Wanted};
pub use own::own_scene;
pub use page::{Section, Table, page};
pub use performance::{Haptic, Pair, PerformanceCatalogue, Place, Sweep, performance, performance_page};
pub use plot::{Axis, Bars, Curve, Heat, Lines};
pub use row::Row;
pub use stability::{
    Account, Balance, Extreme, Map, Point, Scenes, StabilityCatalogue, State, stability, stability_page,
};
pub use table::{csv, markdown};
pub use trial::{Outcome, Trial};
pub use write::{Written, write};

use pliant_host::SearchPath;
use std::collections::BTreeSet;

/// Rows, what people read of them, and what was not run.
pub type Measured = (Vec<Row>, Vec<Section>, Vec<NotRun>);

/// What a report is run with.
pub struct Setup<'a> {
    /// Where plugins are looked for.
    pub search: SearchPath,
    /// Threads of a run; performance tries others besides.
    pub threads: usize,
    /// Fewer levels and steps, within a minute.
    pub quick: bool,
    /// Only cases whose name contains one of these; all where there is none.
    pub only: Vec<String>,
    /// Of the order in which timed runs are interleaved.
    pub seed: u64,
    /// What time is.
    pub clock: Clock,
    /// Plugins that were opened, with their versions.
    pub plugins: BTreeSet<String>,
    /// s, wall by threads, and of the CPU, of all runs
    pub spent: (f64, f64),
    /// Told before each run: done so far, of how many, and what comes.
    pub progress: &'a mut dyn FnMut(usize, usize, &str),
    /// Whether to stop.
    pub stopped: &'a dyn Fn() -> bool,
}

impl Setup<'_> {
    /// Takes note of a run.
    fn ran(&mut self, outcome: &Outcome) {
        self.plugins.extend(outcome.plugins.iter().cloned());
        self.spent.0 += outcome.wall * outcome.choices.threads as f64;
        self.spent.1 += outcome.cpu;
    }

    /// Whether a case is asked for.
    pub fn wants(&self, case: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|o| case.contains(o.as_str()))
    }
}
