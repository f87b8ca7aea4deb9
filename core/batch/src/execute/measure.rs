//! Values of a run for its row: summary and trace.

use crate::column::{ColumnType, float_cell};
use crate::sweep::Keep;
use pliant_engine::session::Session;
use pliant_record::{ProbeResult, RunStatistics, trace_cells, trace_columns, traced_tools};
use serde_json::Value;

/// A column of the summary.
pub(crate) struct SummaryColumn {
    /// Name of the column, without the unit.
    pub(crate) name: &'static str,
    /// Unit of its values in SI; `1` for counts and ratios, empty for values that are not numbers.
    pub(crate) unit: &'static str,
    /// Type of its values.
    pub(crate) column_type: ColumnType,
    /// Reads the value after a run.
    value: fn(&Session, &RunStatistics) -> Value,
}

/// A summary column of floating-point numbers.
const fn float(name: &'static str, unit: &'static str, value: fn(&Session, &RunStatistics) -> Value) -> SummaryColumn {
    SummaryColumn { name, unit, column_type: ColumnType::Float, value }
}

/// A summary column of whole numbers.
const fn integer(name: &'static str, value: fn(&Session, &RunStatistics) -> Value) -> SummaryColumn {
    SummaryColumn { name, unit: "1", column_type: ColumnType::Integer, value }
}

/// All columns of a summary. No value depends on wall-clock time, threads or machine.
pub(crate) const SUMMARY: [SummaryColumn; 15] = [
    integer("steps", |session, _| session.steps().into()),
    float("simulated_time", "s", |session, _| float_cell(session.time())),
    SummaryColumn {
        name: "integrator",
        unit: "",
        column_type: ColumnType::Text,
        value: |session, _| session.choices.integrator.into(),
    },
    integer("substeps", |session, _| session.choices.substeps.into()),
    integer("most_nodes", |_, run| run.most_nodes.into()),
    integer("most_elements", |_, run| run.most_elements.into()),
    integer("contact_steps", |_, run| run.contact_steps.into()),
    float("largest_force", "N", |_, run| float_cell(run.largest_force)),
    integer("iterations", |_, run| run.iterations.into()),
    float("largest_residual", "1", |_, run| float_cell(run.largest_residual)),
    integer("events", |session, _| session.events.counts().values().sum::<u64>().into()),
    integer("cut_advances", |session, _| session.cuts().advances.into()),
    float("cut_area", "m^2", |session, _| float_cell(session.cuts().area)),
    float("cut_length", "m", |session, _| float_cell(session.cuts().length)),
    SummaryColumn {
        name: "passed",
        unit: "",
        column_type: ColumnType::Boolean,
        value: |_, run| passed(&run.probes()).into(),
    },
];

/// Whether every probe with an expected value met it.
fn passed(probes: &[ProbeResult]) -> bool {
    probes.iter().all(|probe| probe.passed != Some(false))
}

/// Cells of the kept columns of the summary.
pub(super) fn summary_cells(keep: &Keep, session: &Session, run: &RunStatistics) -> Vec<Value> {
    let cell = |name: &String| {
        let column = SUMMARY.iter().find(|column| column.name == *name).expect("checked when the sweep was read");
        (column.value)(session, run)
    };
    keep.summary.iter().map(cell).collect()
}

/// The kept columns of a trace.
pub(super) struct TraceKeeper {
    /// Index in the trace of each kept column; `None` for a column that this scene does not have.
    indices: Vec<Option<usize>>,
    /// Steps from one kept row to the next.
    every: u64,
    /// Values by kept column.
    columns: Vec<Vec<Value>>,
}

impl TraceKeeper {
    /// Prepares the columns that `keep` names, for a session.
    pub(super) fn new(keep: &Keep, session: &Session) -> Self {
        let known = if keep.trace.is_empty() { Vec::new() } else { trace_columns(traced_tools(session)) };
        let indices = keep.trace.iter().map(|name| known.iter().position(|column| column == name)).collect();
        Self { indices, every: keep.trace_every, columns: vec![Vec::new(); keep.trace.len()] }
    }

    /// Keeps the row of the last step of the session if it is due. `last`: no step comes after it.
    pub(super) fn step(&mut self, session: &Session, last: bool) {
        if self.columns.is_empty() || !(last || (session.steps() - 1).is_multiple_of(self.every)) {
            return;
        }
        let cells = trace_cells(session.frame());
        for (index, column) in self.indices.iter().zip(&mut self.columns) {
            let Some(text) = index.and_then(|index| cells.get(index)) else { continue };
            column.push(text.parse::<f64>().map_or_else(|_| Value::from(text.as_str()), float_cell));
        }
    }

    /// A cell for each kept column.
    pub(super) fn cells(self) -> impl Iterator<Item = Value> {
        let of_column = |(index, column): (Option<usize>, Vec<Value>)| index.map_or(Value::Null, |_| column.into());
        self.indices.into_iter().zip(self.columns).map(of_column)
    }
}
