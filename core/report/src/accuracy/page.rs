//! The sections of an accuracy report: an overview, then tables and pictures of each case.

use super::catalogue::{AccuracyCase, Refinement};
use crate::fit::exponent;
use crate::plot::{Axis, Curve, LinePlot, format_short};
use crate::row::Row;
use crate::section::{Section, Table};

/// Errors of the overview, for which the fastest method is listed.
const ERROR_GOALS: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// A case and its rows.
struct CaseRows<'a> {
    case: &'a AccuracyCase,
    rows: Vec<&'a Row>,
}

/// The overview, then a section for each case that has rows.
pub(super) fn accuracy_sections<'a>(cases: &'a [AccuracyCase], rows: &'a [Row]) -> Vec<Section> {
    let of_case =
        |case: &'a AccuracyCase| CaseRows { case, rows: rows.iter().filter(|r| r.case == case.name).collect() };
    let cases: Vec<CaseRows<'_>> = cases.iter().map(of_case).filter(|c| !c.rows.is_empty()).collect();
    let mut sections = vec![overview(&cases)];
    sections.extend(cases.iter().map(CaseRows::section));
    sections
}

/// The fastest method for each error.
fn overview(cases: &[CaseRows<'_>]) -> Section {
    let caption = "Which method reaches an error first, and in how many seconds of steps";
    let mut table = Table::new(caption, &["case", "1e-2", "1e-3", "1e-4"]);
    for CaseRows { case, rows } in cases {
        let mut cells = vec![case.name.clone()];
        for goal in ERROR_GOALS {
            let within = rows.iter().filter(|r| r.error.is_some_and(|e| e <= goal));
            let first = within.min_by(|a, b| a.wall_seconds.total_cmp(&b.wall_seconds));
            cells.push(first.map_or_else(
                || "none".into(),
                |r| format!("{}, {}, {} s", r.method, resolution(case, r), format_short(r.wall_seconds)),
            ));
        }
        table.push(cells, false);
    }
    let text = "Each case is a scene with a known answer. Its error is in the norm stated with it. A run must be within the \
                case's tolerance at the resolution the tolerance is meant for; the tolerance of coarser runs grows by the \
                expected order. The finest run of a method must also show that order, to 0.3.";
    Section { title: "Overview".into(), text: vec![text.into()], plots: Vec::new(), tables: vec![table] }
}

/// The resolution of a row, in words.
fn resolution(case: &AccuracyCase, row: &Row) -> String {
    match case.refinement {
        Refinement::Space => format!("n = {}", row.n),
        Refinement::Time => format!("dt = {} s", format_short(row.dt)),
    }
}

impl CaseRows<'_> {
    /// The section of the case: error against run time, error against resolution, and the table of runs.
    fn section(&self) -> Section {
        let case = self.case;
        let work = LinePlot {
            title: format!("{}: error against run time; large marks: nothing is both faster and more exact", case.name),
            x: Axis::log("wall-clock time of the steps (s)"),
            y: Axis::log("error (relative, 1)"),
            curves: self.curves(&|r| r.wall_seconds, true),
        };
        let mut convergence = LinePlot {
            title: format!("{}: error against resolution", case.name),
            x: Axis::log(match case.refinement {
                Refinement::Space => "cells along the edge (1)",
                Refinement::Time => "step (s)",
            }),
            y: Axis::log("error (relative, 1)"),
            curves: self.curves(&|r| self.size(r), false),
        };
        convergence.curves.extend(self.expected_slopes());
        let mut text = vec![format!("{}. Error: {}. Source: {}.", case.title, case.norm, case.source)];
        let fitted = self.fitted_orders();
        if !fitted.is_empty() {
            text.push(format!("Order fitted over all runs: {}.", fitted.join("; ")));
        }
        let plots =
            vec![(format!("{}-work", case.name), work.svg()), (format!("{}-order", case.name), convergence.svg())];
        Section { title: format!("{}: {}", case.name, case.title), text, plots, tables: vec![self.table()] }
    }

    /// The methods in the order of the rows.
    fn methods(&self) -> Vec<&str> {
        let mut methods: Vec<&str> = self.rows.iter().map(|r| r.method.as_str()).collect();
        methods.dedup();
        methods
    }

    /// The refined quantity of a row: cells along the edge, or the step (s).
    fn size(&self, row: &Row) -> f64 {
        match self.case.refinement {
            Refinement::Space => row.n as f64,
            Refinement::Time => row.dt,
        }
    }

    /// Sign of the slope of an error over [`CaseRows::size`].
    fn slope_sign(&self) -> f64 {
        match self.case.refinement {
            Refinement::Space => -1.0,
            Refinement::Time => 1.0,
        }
    }

    /// A curve of errors over `x` for each method, with large marks on the Pareto front if `marked`.
    fn curves(&self, x: &dyn Fn(&Row) -> f64, marked: bool) -> Vec<Curve> {
        let curve = |method: &&str| {
            let of: Vec<&&Row> = self.rows.iter().filter(|r| r.method == **method && r.error.is_some()).collect();
            Curve {
                name: (*method).into(),
                // An exact result has no logarithm.
                points: of.iter().map(|r| (x(r), r.error.unwrap_or(f64::NAN).max(1e-16))).collect(),
                large: of.iter().map(|r| marked && r.on_front).collect(),
                theory: false,
            }
        };
        self.methods().iter().map(curve).collect()
    }

    /// A dashed line for every expected order, through the coarsest error of a method that should show it.
    fn expected_slopes(&self) -> Vec<Curve> {
        let mut orders: Vec<f64> = self.rows.iter().filter_map(|r| r.expected_order).collect();
        orders.sort_by(f64::total_cmp);
        orders.dedup();
        let line = |p: &f64| {
            let of: Vec<&&Row> =
                self.rows.iter().filter(|r| r.expected_order == Some(*p) && r.error.is_some()).collect();
            let first = of.first()?;
            let last = of.iter().rfind(|r| r.method == first.method)?;
            let (a, b, error) = (self.size(first), self.size(last), first.error?);
            let points = vec![(a, error), (b, error * (b / a).powf(self.slope_sign() * p))];
            Some(Curve { name: format!("order {p}"), points, large: Vec::new(), theory: true })
        };
        orders.iter().filter_map(line).collect()
    }

    /// Each method with the order fitted over all of its runs.
    fn fitted_orders(&self) -> Vec<String> {
        let fit = |method: &&str| {
            let of = self.rows.iter().filter(|r| r.method == **method && r.error.is_some_and(|e| e > self.case.floor));
            let points: Vec<(f64, f64)> = of.map(|r| (self.size(r), r.error.unwrap_or(f64::NAN))).collect();
            let order = exponent(&points)? * self.slope_sign();
            Some(format!("{method} {order:.2}"))
        };
        self.methods().iter().filter_map(fit).collect()
    }

    /// All runs with their errors, orders and cost.
    fn table(&self) -> Table {
        let n = match self.case.refinement {
            Refinement::Space => "n (cells)",
            Refinement::Time => "n",
        };
        let mut head = vec!["method", n, "dt (s)", "error (1)", "allowed (1)", "order", "expected", "wall (s)"];
        head.extend(["CPU (s)", "memory (MB)", "iterations", "verdict"]);
        let mut table = Table::new("Runs", &head);
        for r in &self.rows {
            let number = |v: Option<f64>| v.map_or_else(|| "-".into(), format_short);
            let mut cells = vec![r.method.clone(), r.n.to_string(), format_short(r.dt)];
            cells.extend([number(r.error), number(r.tolerance)]);
            cells.extend([number(r.order), number(r.expected_order)]);
            cells.extend([format_short(r.wall_seconds), format_short(r.cpu_seconds)]);
            cells.extend([format_short(r.bytes as f64 / 1e6), r.iterations.to_string()]);
            cells.push(match (r.passed, r.on_front) {
                (Some(false), _) => format!("failed: {}", r.note),
                (_, true) => "within; on the front".into(),
                _ => "within".into(),
            });
            table.push(cells, r.failed());
        }
        table
    }
}
