//! The sections of a performance report.

use super::catalogue::Sweep;
use super::timed_case::STAGES;
use crate::plot::{Axis, Curve, LinePlot, StackedBars, format_short};
use crate::row::Row;
use crate::section::{Section, Table};

/// A section for each sweep, then what leaving out saves, start-up and the haptic loop, as far as there are rows of them.
pub(super) fn performance_sections(sweeps: &[Sweep], rows: &[Row]) -> Vec<Section> {
    let mut out: Vec<Section> = sweeps.iter().filter_map(|sweep| SweepRows::new(sweep, rows)?.section(rows)).collect();
    out.extend(left_out_section(rows));
    out.extend(start_up_section(rows));
    out.extend(haptic_section(rows));
    out
}

/// A result of a row; NaN where it has none.
fn result(r: &Row, key: &str) -> f64 {
    r.results.get(key).copied().unwrap_or(f64::NAN)
}

/// Median step time of a row, s.
fn step_seconds(r: &Row) -> f64 {
    r.step_seconds_median.unwrap_or(f64::NAN)
}

/// A time (s) in ms, as text.
fn milliseconds(seconds: f64) -> String {
    format_short(1e3 * seconds)
}

/// A sweep and its timed rows.
struct SweepRows<'a> {
    sweep: &'a Sweep,
    rows: Vec<&'a Row>,
    /// Parameter along the sweep, by name and unit; the number of nodes where there is none.
    parameter: Option<&'a str>,
}

impl<'a> SweepRows<'a> {
    /// The rows of a sweep; `None` without any.
    fn new(sweep: &'a Sweep, rows: &'a [Row]) -> Option<Self> {
        let rows: Vec<&Row> = rows.iter().filter(|r| r.case == sweep.name && r.step_seconds_median.is_some()).collect();
        let parameter = sweep.points.first().and_then(|p| p.parameters.keys().next()).map(String::as_str);
        (!rows.is_empty()).then_some(Self { sweep, rows, parameter })
    }

    /// Value of the parameter along the sweep.
    fn x(&self, r: &Row) -> f64 {
        self.parameter.map_or_else(|| result(r, "nodes"), |name| r.parameters[name])
    }

    /// Name and unit of the parameter along the sweep.
    fn label(&self) -> &str {
        self.parameter.unwrap_or("nodes (1)")
    }

    /// The section; `rows` are all rows of the report.
    fn section(&self, rows: &[Row]) -> Option<Section> {
        let sweep = self.sweep;
        let mut section = Section { title: format!("{}: {}", sweep.name, sweep.title), ..Section::default() };
        section.plots.push((sweep.name.clone(), self.time_plot().svg()));
        section.plots.push((format!("{}-stages", sweep.name), self.stage_bars().svg()));
        section.tables = vec![self.time_table(), self.model_table()];
        for r in rows.iter().filter(|r| r.case == format!("growth: {}", sweep.name)) {
            let (order, expected) = (r.order.unwrap_or(f64::NAN), r.expected_order.unwrap_or(f64::NAN));
            let word = if r.failed() { "more than expected" } else { "as expected" };
            section.text.push(format!(
                "With {} thread(s) the time of a step grows with the nodes to the power of {order:.2}; expected is \
                 {expected}: {word}.",
                r.threads
            ));
        }
        Some(section)
    }

    /// Time of a step along the sweep, a curve for each number of threads.
    fn time_plot(&self) -> LinePlot {
        let curve = |&threads: &usize| {
            let on = self.rows.iter().filter(|r| r.threads == threads);
            let name = format!("{threads} thread{}", if threads == 1 { "" } else { "s" });
            Curve { name, points: on.map(|r| (self.x(r), step_seconds(r))).collect(), ..Curve::default() }
        };
        let mut curves: Vec<Curve> = self.sweep.threads.iter().map(curve).filter(|c| !c.points.is_empty()).collect();
        if let (Some(p), Some(first), Some(last)) = (self.sweep.growth, self.rows.first(), self.rows.last()) {
            let (a, b) = (self.x(first), self.x(last));
            let points = vec![(a, step_seconds(first)), (b, step_seconds(first) * (b / a).powf(p))];
            curves.push(Curve { name: format!("nodes to the power of {p}"), points, theory: true, ..Curve::default() });
        }
        LinePlot {
            title: format!("{}: a step", self.sweep.name),
            x: Axis::log(self.label()),
            y: Axis::log("median of a step (s)"),
            curves,
        }
    }

    /// Shares of the stages in a step, with the first number of threads.
    fn stage_bars(&self) -> StackedBars {
        let bar = |r: &&Row| {
            let stages = STAGES.map(|stage| result(r, &format!("{stage} (s)"))).to_vec();
            (format_short(self.x(r)), stages)
        };
        StackedBars {
            title: format!("{}: shares of a step, 1 thread", self.sweep.name),
            x: self.label().into(),
            y: "share of a step (%)".into(),
            parts: STAGES.map(String::from).to_vec(),
            bars: self.first_threads().map(bar).collect(),
        }
    }

    /// Rows with the first number of threads.
    fn first_threads(&self) -> impl Iterator<Item = &&'a Row> {
        self.rows.iter().filter(|r| r.threads == self.sweep.threads[0])
    }

    /// Times of all rows.
    fn time_table(&self) -> Table {
        let mut head = vec![self.label(), "threads", "median (ms)", "p99 (ms)", "spread (%)", "regions (ms)"];
        head.extend(["contact (ms)", "integration (ms)", "contacts", "iterations a step", "open (ms)"]);
        let mut table = Table::new(format!("A step: {}", self.sweep.method), &head);
        for r in &self.rows {
            let mut cells = vec![format_short(self.x(r)), r.threads.to_string(), milliseconds(step_seconds(r))];
            cells.push(milliseconds(r.step_seconds_p99.unwrap_or(f64::NAN)));
            cells.push(format_short(100.0 * r.spread.unwrap_or(f64::NAN)));
            cells.extend(STAGES.map(|stage| milliseconds(result(r, &format!("{stage} (s)")))));
            cells.extend([format_short(result(r, "contacts")), format_short(result(r, "iterations a step"))]);
            cells.push(milliseconds(r.open_seconds));
            table.push(cells, false);
        }
        table
    }

    /// Operations and memory of the model beside the measured time and memory.
    fn model_table(&self) -> Table {
        let caption = "Beside the model of Tripicchio et al. (2022): 7940 Nv + 36 Nc + (156 Nv + 36 Nc) Ni operations, 607 Nv numbers";
        let mut head = vec![self.label(), "flop a step, model", "model over time (Gflop/s)", "memory, model (MB)"];
        head.extend(["memory, largest parts (MB)", "peak of the program so far (MB)"]);
        let mut table = Table::new(caption, &head);
        for r in self.first_threads() {
            let mega = |v: f64| format_short(1e-6 * v);
            let mut cells = vec![format_short(self.x(r)), format_short(result(r, "model (flop a step)"))];
            cells.push(format_short(1e-9 * result(r, "model over time (flop/s)")));
            cells.extend([mega(result(r, "model (bytes)")), mega(r.bytes as f64)]);
            cells.push(mega(result(r, "peak of the program so far (bytes)")));
            table.push(cells, false);
        }
        table
    }
}

/// Time saved by leaving parts out.
fn left_out_section(rows: &[Row]) -> Option<Section> {
    let head = ["what", "as it is (ms a step)", "with it (ms a step)", "saved (%)", "spread of either (%)"];
    let mut table = Table::new("Each scene against itself", &head);
    for r in rows.iter().filter(|r| r.case.starts_with("left-out") && r.method == "as it is") {
        let Some(with) = rows.iter().find(|w| w.case == r.case && w.method == "with it") else { continue };
        let [a, b] = [r, with].map(|r| result(r, "wall a step (s)"));
        let spread = r.spread.unwrap_or(f64::NAN).max(with.spread.unwrap_or(f64::NAN));
        let name = r.case.trim_start_matches("left-out: ").to_owned();
        let (saved, spread) = (format_short(100.0 * (1.0 - a / b)), format_short(100.0 * spread));
        table.push(vec![name, milliseconds(a), milliseconds(b), saved, spread], false);
    }
    let text =
        "Wall-clock time of a whole step with its output, run in turn. A saving below the spread is not significant.";
    (!table.rows.is_empty()).then(|| Section {
        title: "What was left out, and what it saved".into(),
        text: vec![text.into()],
        tables: vec![table],
        ..Section::default()
    })
}

/// The start of the program.
fn start_up_section(rows: &[Row]) -> Option<Section> {
    let mut table = Table::new("Start", &["what", "median (ms)", "spread (%)"]);
    for r in rows.iter().filter(|r| r.case == "start-up") {
        let spread = format_short(100.0 * r.spread.unwrap_or(f64::NAN));
        table.push(vec![r.method.clone(), milliseconds(r.wall_seconds), spread], false);
    }
    (!table.rows.is_empty()).then(|| Section {
        title: "Start-up".into(),
        text: vec!["The time of opening each scene is in the tables above.".into()],
        tables: vec![table],
        ..Section::default()
    })
}

/// Lateness of the haptic loop.
fn haptic_section(rows: &[Row]) -> Option<Section> {
    let of: Vec<&Row> = rows.iter().filter(|r| r.case == "haptic-loop").collect();
    let keys = ["late, median (s)", "late, p99 (s)", "late, p99.9 (s)", "late, most (s)"];
    let mut head = vec!["scene", "rate (Hz)", "ticks", "missed", "real time kept (%)"];
    head.extend(["late, median (ms)", "p99 (ms)", "p99.9 (ms)", "most (ms)", "p99 allowed (ms)", "verdict"]);
    let mut table = Table::new("How late ticks begin", &head);
    for r in &of {
        let mut cells = vec![r.method.clone(), format_short(1.0 / r.dt), format_short(result(r, "ticks"))];
        cells.push(format_short(result(r, "missed ticks")));
        cells.push(format_short(100.0 * result(r, "share of real time kept")));
        cells.extend(keys.map(|key| milliseconds(result(r, key))));
        cells.push(milliseconds(r.tolerance.unwrap_or(f64::NAN)));
        cells.push(if r.failed() { format!("failed; {}", r.note) } else { "within".into() });
        table.push(cells, r.failed());
    }
    let text = "The same scenes in real time, with the haptic loop, the simulation and the watchdog each in a thread of its \
                own. The load of the machine affects these times.";
    let title = "The haptic loop".into();
    (!of.is_empty()).then(|| Section { title, text: vec![text.into()], tables: vec![table], ..Section::default() })
}
