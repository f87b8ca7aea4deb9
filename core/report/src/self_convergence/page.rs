//! The sections of a self-convergence report, one for the forces and one for the surface.

use super::front::Front;
use super::series::{LEVEL, RefinementSeries, STEP, TOLERANCE};
use crate::plot::{Axis, Curve, LinePlot, format_short};
use crate::row::Row;
use crate::section::{Section, Table};

/// Label of the errors.
const ERROR_LABEL: &str = "difference from the reference (relative, 1)";

/// A section for each case among the rows.
pub(super) fn sections(fronts: &[Front], rows: &[Row]) -> Vec<Section> {
    let mut cases: Vec<&str> = rows.iter().filter(|r| r.error.is_some()).map(|r| r.case.as_str()).collect();
    cases.sort_unstable();
    cases.dedup();
    let of_front = |front| cases.iter().map(move |case| CaseRows { case, front, rows }).filter(CaseRows::has_rows);
    fronts.iter().flat_map(of_front).map(|case| case.section()).collect()
}

/// A case, the front whose runs it compares, and all rows of the report.
struct CaseRows<'a> {
    case: &'a str,
    front: &'a Front,
    rows: &'a [Row],
}

impl CaseRows<'_> {
    /// Whether the case has rows of the front.
    fn has_rows(&self) -> bool {
        self.front.series.iter().any(|series| !self.of(series).is_empty())
    }

    /// The section of the case: error against run time and against each refined setting, and the table of runs.
    fn section(&self) -> Section {
        let case = self.case;
        let work = LinePlot {
            title: format!("{case}: error against run time"),
            x: Axis::log("wall-clock time of the steps (s)"),
            y: Axis::log(ERROR_LABEL),
            curves: self
                .front
                .series
                .iter()
                .map(|series| self.curve(series, &|r| r.wall_seconds, true))
                .filter(|c| !c.points.is_empty())
                .collect(),
        };
        let mut plots = vec![(format!("{}-work", file_name(case)), work.svg())];
        for path in [STEP, TOLERANCE, LEVEL] {
            let along: Vec<&RefinementSeries> =
                self.front.series.iter().filter(|s| s.path == path && !self.of(s).is_empty()).collect();
            let Some(first) = along.first() else { continue };
            let picture = LinePlot {
                title: format!("{case}: against {}", first.axis),
                x: if path == LEVEL { Axis::linear(first.axis) } else { Axis::log(first.axis) },
                y: Axis::log(ERROR_LABEL),
                curves: along.iter().map(|series| self.curve(series, &|r| r.parameters[path], false)).collect(),
            };
            plots.push((format!("{}-{}", file_name(case), file_name(path)), picture.svg()));
        }
        let text = "Force: root mean square of the difference over that of the force, at common times, before force safety. Surface: largest \
                    distance at the end over the largest displacement.";
        let mut references: Vec<&str> =
            self.front.series.iter().flat_map(|series| self.of(series)).map(|row| &*row.reference).collect();
        references.dedup();
        let reference = format!("Reference: the same scene with {}. {}", references.join("; or "), self.front.why);
        Section { title: case.into(), text: vec![reference, text.into()], plots, tables: vec![self.table()] }
    }

    /// Rows of a series that have an error.
    fn of(&self, series: &RefinementSeries) -> Vec<&Row> {
        let wanted = |r: &&Row| r.case == self.case && r.method == series.name && r.error.is_some();
        self.rows.iter().filter(wanted).collect()
    }

    /// Errors of a series over `x`, with large marks on the Pareto front if `marked`.
    fn curve(&self, series: &RefinementSeries, x: &dyn Fn(&Row) -> f64, marked: bool) -> Curve {
        let of = self.of(series);
        Curve {
            name: series.name.clone(),
            // An exact result has no logarithm.
            points: of.iter().map(|r| (x(r), r.error.unwrap_or(f64::NAN).max(1e-16))).collect(),
            large: of.iter().map(|r| marked && r.on_front).collect(),
            theory: false,
        }
    }

    /// All runs of the case.
    fn table(&self) -> Table {
        let head = ["what is refined", "value", "error (1)", "order", "wall (s)", "CPU (s)", "iterations", "front"];
        let mut table = Table::new("Runs", &head);
        for r in self.front.series.iter().flat_map(|series| self.of(series)) {
            let (path, value) = r.parameters.first_key_value().map_or(("", 0.0), |(k, v)| (k.as_str(), *v));
            let error = r.error.map_or_else(|| "-".into(), format_short);
            let order = r.order.map_or_else(|| "-".into(), |o| format!("{o:.2}"));
            let (wall, cpu) = (format_short(r.wall_seconds), format_short(r.cpu_seconds));
            let front = if r.on_front { "yes" } else { "" };
            let (method, value) = (format!("{}: {path}", r.method), format_short(value));
            table
                .push(vec![method, value, error, order, wall, cpu, r.iterations.to_string(), front.into()], r.failed());
        }
        table
    }
}

/// A text as part of a file name.
fn file_name(text: &str) -> String {
    text.replace([' ', ':', ',', '.'], "-").replace("--", "-")
}
