//! Accuracy, as people read it.

use super::catalogue::{Case, Catalogue, Over};
use super::page::{Section, Table};
use super::plot::{Axis, Curve, Lines, short};
use super::{Row, exponent};

/// Errors that are asked for.
const WANTED: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// The overview, then a section a case.
pub fn accuracy_page(catalogue: &Catalogue, rows: &[Row]) -> Vec<Section> {
    let cases = catalogue.case.iter().filter_map(|case| {
        let of_case: Vec<&Row> = rows.iter().filter(|r| r.case == case.name).collect();
        (!of_case.is_empty()).then_some((case, of_case))
    });
    let cases: Vec<(&Case, Vec<&Row>)> = cases.collect();
    let mut sections = vec![overview(&cases)];
    sections.extend(cases.iter().map(|(case, rows)| of_case(case, rows)));
    sections
}

fn overview(cases: &[(&Case, Vec<&Row>)]) -> Section {
    let mut table = Table {
        caption: "Which method reaches an error first, and in how many seconds of steps".into(),
        head: ["case", "1e-2", "1e-3", "1e-4"].map(String::from).to_vec(),
        rows: Vec::new(),
    };
    for (case, rows) in cases {
        let mut cells = vec![case.name.clone()];
        for wanted in WANTED {
            let within = rows.iter().filter(|r| r.error.is_some_and(|e| e <= wanted));
            let first = within.min_by(|a, b| a.wall_seconds.total_cmp(&b.wall_seconds));
            cells.push(first.map_or_else(
                || "none".into(),
                |r| format!("{}, {}, {} s", r.method, resolution(case, r), short(r.wall_seconds)),
            ));
        }
        table.rows.push((cells, false));
    }
    let text = "Each case is a scene with a known answer. Its error is taken in the norm stated with it. A run must be within \
                the case's tolerance at the resolution the tolerance is meant for; coarser runs may be off by more, by the \
                expected order. The finest run of a method must also show that order, to 0.3.";
    Section { title: "Overview".into(), text: vec![text.into()], plots: Vec::new(), tables: vec![table] }
}

fn resolution(case: &Case, row: &Row) -> String {
    if case.over == Over::N { format!("n = {}", row.n) } else { format!("dt = {} s", short(row.dt)) }
}

fn of_case(case: &Case, rows: &[&Row]) -> Section {
    let mut methods: Vec<&str> = rows.iter().map(|r| r.method.as_str()).collect();
    methods.dedup();
    let size = |r: &Row| if case.over == Over::N { r.n as f64 } else { r.dt };
    let curves = |x: &dyn Fn(&Row) -> f64, marked: bool| -> Vec<Curve> {
        let curve = |method: &&str| {
            let of: Vec<&&Row> = rows.iter().filter(|r| r.method == **method && r.error.is_some()).collect();
            Curve {
                name: (*method).into(),
                points: of.iter().map(|r| (x(r), r.error.unwrap_or(f64::NAN).max(1e-16))).collect(),
                large: of.iter().map(|r| marked && r.front).collect(),
                theory: false,
            }
        };
        methods.iter().map(curve).collect()
    };
    let work = Lines {
        title: format!("{}: error against run time; large marks: nothing is both faster and more exact", case.name),
        x: Axis::log("wall-clock time of the steps (s)"),
        y: Axis::log("error (relative, 1)"),
        curves: curves(&|r| r.wall_seconds, true),
    };
    let along = if case.over == Over::N { "cells along the edge (1)" } else { "step (s)" };
    let mut convergence = Lines {
        title: format!("{}: error against resolution", case.name),
        x: Axis::log(along),
        y: Axis::log("error (relative, 1)"),
        curves: curves(&size, false),
    };
    convergence.curves.extend(slopes(case, rows, &size));
    let mut table = Table { caption: "Runs".into(), head: head(case), rows: Vec::new() };
    for r in rows {
        let number = |v: Option<f64>| v.map_or_else(|| "-".into(), short);
        let mut cells = vec![r.method.clone(), r.n.to_string(), short(r.dt)];
        cells.extend([number(r.error), number(r.tolerance)]);
        cells.extend([number(r.order), number(r.expected_order)]);
        cells.extend([
            short(r.wall_seconds),
            short(r.cpu_seconds),
            short(r.bytes as f64 / 1e6),
            r.iterations.to_string(),
        ]);
        cells.push(match (r.passed, r.front) {
            (Some(false), _) => format!("missed: {}", r.note.trim_end_matches([';', ' '])),
            (_, true) => "within; on the front".into(),
            _ => "within".into(),
        });
        table.rows.push((cells, r.missed()));
    }
    let fitted: Vec<String> = methods
        .iter()
        .filter_map(|m| {
            let of = rows.iter().filter(|r| r.method == *m && r.error.is_some_and(|e| e > case.floor));
            let points: Vec<(f64, f64)> = of.map(|r| (size(r), r.error.unwrap_or(f64::NAN))).collect();
            let p = exponent(&points)? * if case.over == Over::N { -1.0 } else { 1.0 };
            Some(format!("{m} {p:.2}"))
        })
        .collect();
    let mut text = vec![format!("{}. Error: {}. Source: {}.", case.title, case.norm, case.source)];
    if !fitted.is_empty() {
        text.push(format!("Order fitted over all runs: {}.", fitted.join("; ")));
    }
    let plots = vec![(format!("{}-work", case.name), work.svg()), (format!("{}-order", case.name), convergence.svg())];
    Section { title: format!("{}: {}", case.name, case.title), text, plots, tables: vec![table] }
}

fn head(case: &Case) -> Vec<String> {
    let n = if case.over == Over::N { "n (cells)" } else { "n" };
    let names = ["method", n, "dt (s)", "error (1)", "allowed (1)", "order", "expected", "wall (s)", "CPU (s)"];
    let mut head = names.map(String::from).to_vec();
    head.extend(["memory (MB)", "iterations", "verdict"].map(String::from));
    head
}

/// A dashed line for every order that is expected, through the coarsest error of a method that should show it.
fn slopes(case: &Case, rows: &[&Row], size: &dyn Fn(&Row) -> f64) -> Vec<Curve> {
    let mut orders: Vec<f64> = rows.iter().filter_map(|r| r.expected_order).collect();
    orders.sort_by(f64::total_cmp);
    orders.dedup();
    let sign = if case.over == Over::N { -1.0 } else { 1.0 };
    let line = |p: &f64| {
        let of: Vec<&&Row> = rows.iter().filter(|r| r.expected_order == Some(*p) && r.error.is_some()).collect();
        let first = of.first()?;
        let last = of.iter().rfind(|r| r.method == first.method)?;
        let (a, b, e) = (size(first), size(last), first.error?);
        let points = vec![(a, e), (b, e * (b / a).powf(sign * p))];
        Some(Curve { name: format!("order {p}"), points, large: Vec::new(), theory: true })
    };
    orders.iter().filter_map(line).collect()
}
