//! Performance, as people read it.

use super::{PerformanceCatalogue, STAGES, Sweep};
use crate::Row;
use crate::page::{Section, Table};
use crate::plot::{Axis, Bars, Curve, Lines, short};

/// The sections.
pub fn performance_page(catalogue: &PerformanceCatalogue, rows: &[Row]) -> Vec<Section> {
    let mut out: Vec<Section> = catalogue.sweep.iter().filter_map(|s| sweep(s, rows)).collect();
    out.extend(left_out(rows));
    out.extend(start_up(rows));
    out.extend(haptic(rows));
    out
}

fn found(r: &Row, key: &str) -> f64 {
    r.found.get(key).copied().unwrap_or(f64::NAN)
}

fn sweep(sweep: &Sweep, rows: &[Row]) -> Option<Section> {
    let of: Vec<&Row> = rows.iter().filter(|r| r.case == sweep.name && r.step_seconds_median.is_some()).collect();
    let along = sweep.place.first().and_then(|p| p.at.keys().next());
    let x = |r: &Row| along.map_or_else(|| found(r, "nodes"), |name| r.at[name]);
    let label = along.map_or("nodes (1)", |name| name.as_str());
    let mut section = Section { title: format!("{}: {}", sweep.name, sweep.title), ..Section::default() };
    let seconds = |r: &Row| r.step_seconds_median.unwrap_or(f64::NAN);
    let mut curves: Vec<Curve> = sweep
        .threads
        .iter()
        .map(|&threads| {
            let on = of.iter().filter(|r| r.threads == threads);
            let name = format!("{threads} thread{}", if threads == 1 { "" } else { "s" });
            Curve { name, points: on.map(|r| (x(r), seconds(r))).collect(), ..Curve::default() }
        })
        .filter(|c| !c.points.is_empty())
        .collect();
    if let (Some(p), Some(first), Some(last)) = (sweep.growth, of.first(), of.last()) {
        let points = vec![(x(first), seconds(first)), (x(last), seconds(first) * (x(last) / x(first)).powf(p))];
        curves.push(Curve { name: format!("nodes to the power of {p}"), points, theory: true, ..Curve::default() });
    }
    let picture = Lines {
        title: format!("{}: a step", sweep.name),
        x: Axis::log(label),
        y: Axis::log("median of a step (s)"),
        curves,
    };
    section.plots.push((sweep.name.clone(), picture.svg()));
    let one: Vec<&&Row> = of.iter().filter(|r| r.threads == sweep.threads[0]).collect();
    let bars = Bars {
        title: format!("{}: where a step's time goes, 1 thread", sweep.name),
        x: label.into(),
        y: "share of a step (%)".into(),
        parts: STAGES.map(String::from).to_vec(),
        bars: one.iter().map(|r| (short(x(r)), STAGES.map(|s| found(r, &format!("{s} (s)"))).to_vec())).collect(),
    };
    section.plots.push((format!("{}-stages", sweep.name), bars.svg()));
    let head =
        [label, "threads", "median (ms)", "p99 (ms)", "spread (%)", "regions (ms)", "contact (ms)", "integration (ms)"];
    let mut table =
        Table { caption: format!("A step: {}", sweep.method), head: head.map(String::from).to_vec(), rows: vec![] };
    table.head.extend(["contacts", "iterations a step", "open (ms)"].map(String::from));
    let head =
        [label, "flop a step, model", "model over time (Gflop/s)", "memory, model (MB)", "memory, largest parts (MB)"];
    let mut model = Table {
        caption: "Beside the model of Tripicchio et al. (2022): 7940 Nv + 36 Nc + (156 Nv + 36 Nc) Ni operations, 607 Nv numbers"
            .into(),
        head: head.map(String::from).to_vec(),
        rows: vec![],
    };
    model.head.push("most the program held so far (MB)".into());
    for r in &of {
        let ms = |v: f64| short(1e3 * v);
        let mut cells =
            vec![short(x(r)), r.threads.to_string(), ms(seconds(r)), ms(r.step_seconds_p99.unwrap_or(f64::NAN))];
        cells.push(short(100.0 * r.spread.unwrap_or(f64::NAN)));
        cells.extend(STAGES.map(|s| ms(found(r, &format!("{s} (s)")))));
        cells.extend([short(found(r, "contacts")), short(found(r, "iterations a step")), ms(r.open_seconds)]);
        table.rows.push((cells, false));
        if r.threads == sweep.threads[0] {
            let mega = |v: f64| short(1e-6 * v);
            let mut cells = vec![short(x(r)), short(found(r, "model (flop a step)"))];
            cells.push(short(1e-9 * found(r, "model over time (flop/s)")));
            cells.extend([mega(found(r, "model (bytes)")), mega(r.bytes as f64)]);
            cells.push(mega(found(r, "peak of the program so far (bytes)")));
            model.rows.push((cells, false));
        }
    }
    section.tables = vec![table, model];
    for r in rows.iter().filter(|r| r.case == format!("growth: {}", sweep.name)) {
        let (order, expected) = (r.order.unwrap_or(f64::NAN), r.expected_order.unwrap_or(f64::NAN));
        let word = if r.missed() { "more than expected" } else { "as expected" };
        section.text.push(format!(
            "With {} thread(s) a step grows with the nodes to the power of {order:.2}; expected is {expected}: {word}.",
            r.threads
        ));
    }
    (!of.is_empty()).then_some(section)
}

fn left_out(rows: &[Row]) -> Option<Section> {
    let head = ["what", "as it is (ms a step)", "with it (ms a step)", "saved (%)", "spread of either (%)"];
    let mut table =
        Table { caption: "Each scene against itself".into(), head: head.map(String::from).to_vec(), rows: vec![] };
    for r in rows.iter().filter(|r| r.case.starts_with("left-out") && r.method == "as it is") {
        let Some(with) = rows.iter().find(|w| w.case == r.case && w.method == "with it") else { continue };
        let [a, b] = [r, with].map(|r| found(r, "wall a step (s)"));
        let spread = r.spread.unwrap_or(f64::NAN).max(with.spread.unwrap_or(f64::NAN));
        let name = r.case.trim_start_matches("left-out: ").to_owned();
        let cells = vec![name, short(1e3 * a), short(1e3 * b), short(100.0 * (1.0 - a / b)), short(100.0 * spread)];
        table.rows.push((cells, false));
    }
    let text = "Wall-clock time of a whole step, energies and all, run in turn. What saves less than the spread saves nothing \
                that can be told.";
    let title = "What was left out, and what it saved".into();
    (!table.rows.is_empty()).then(|| Section {
        title,
        text: vec![text.into()],
        tables: vec![table],
        ..Section::default()
    })
}

fn start_up(rows: &[Row]) -> Option<Section> {
    let head = ["what", "median (ms)", "spread (%)"];
    let mut table = Table { caption: "Start".into(), head: head.map(String::from).to_vec(), rows: vec![] };
    for r in rows.iter().filter(|r| r.case == "start-up") {
        let spread = short(100.0 * r.spread.unwrap_or(f64::NAN));
        table.rows.push((vec![r.method.clone(), short(1e3 * r.wall_seconds), spread], false));
    }
    let text = vec!["Opening each scene stands in the tables above.".into()];
    (!table.rows.is_empty()).then(|| Section {
        title: "Start-up".into(),
        text,
        tables: vec![table],
        ..Section::default()
    })
}

fn haptic(rows: &[Row]) -> Option<Section> {
    let of: Vec<&Row> = rows.iter().filter(|r| r.case == "haptic-loop").collect();
    let names = ["late, median (s)", "late, p99 (s)", "late, p99.9 (s)", "late, most (s)"];
    let mut head = vec!["scene", "rate (Hz)", "ticks", "missed", "real time kept (%)"];
    head.extend(["late, median (ms)", "p99 (ms)", "p99.9 (ms)", "most (ms)", "p99 allowed (ms)", "verdict"]);
    let head = head.into_iter().map(String::from).collect();
    let mut table = Table { caption: "How late ticks begin".into(), head, rows: vec![] };
    for r in &of {
        let mut cells =
            vec![r.method.clone(), short(1.0 / r.dt), short(found(r, "ticks")), short(found(r, "missed ticks"))];
        cells.push(short(100.0 * found(r, "share of real time kept")));
        cells.extend(names.map(|n| short(1e3 * found(r, n))));
        cells.push(short(1e3 * r.tolerance.unwrap_or(f64::NAN)));
        cells.push(if r.missed() { format!("missed; {}", r.note) } else { "within".into() });
        table.rows.push((cells, r.missed()));
    }
    let text = "The same scenes by the wall clock, with the haptic loop, the simulation and the watchdog each in a thread of its \
                own. What else the machine does shows here.";
    let title = "The haptic loop".into();
    (!of.is_empty()).then(|| Section { title, text: vec![text.into()], tables: vec![table], ..Section::default() })
}
