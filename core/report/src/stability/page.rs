//! Stability, as people read it.

use super::catalogue::{Account, StabilityCatalogue};
use crate::Row;
use crate::page::{Section, Table};
use crate::plot::{Axis, Curve, Heat, Lines, short};

/// The sections.
pub fn stability_page(catalogue: &StabilityCatalogue, rows: &[Row]) -> Vec<Section> {
    let mut out: Vec<Section> = catalogue.map.iter().filter_map(|m| map(m, rows)).collect();
    out.extend(balances(catalogue, rows));
    out.extend(extremes(rows));
    out.extend(coupling(rows));
    out
}

fn map(map: &super::Map, rows: &[Row]) -> Option<Section> {
    let of_map: Vec<&Row> = rows.iter().filter(|r| r.case == map.name).collect();
    let sorted = |values: Vec<f64>| {
        let mut values = values;
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let value = |r: &Row| r.at.get(&map.along).copied().unwrap_or(f64::NAN);
    let columns = sorted(of_map.iter().map(|r| value(r)).collect());
    let steps = sorted(of_map.iter().map(|r| r.dt).collect());
    let mut section = Section { title: format!("{}: {}", map.name, map.title), ..Section::default() };
    for integrator in &map.integrator {
        let at = |x: f64, dt: f64| of_map.iter().find(|r| r.method == *integrator && value(r) == x && r.dt == dt);
        let state = |dt: &f64| columns.iter().map(|x| at(*x, *dt).map_or(String::new(), |r| r.state.clone())).collect();
        let limit = |x: &f64| steps.iter().find_map(|dt| at(*x, *dt)?.found.get("predicted").copied());
        let heat = Heat {
            title: format!("{}: {integrator}", map.name),
            x: map.along.clone(),
            y: "step (s)".into(),
            columns: columns.clone(),
            rows: steps.clone(),
            states: steps.iter().map(state).collect(),
            predicted: columns.iter().map(limit).collect(),
        };
        section.plots.push((format!("{}-{integrator}", map.name), heat.svg()));
    }
    let count = |state: &str| of_map.iter().filter(|r| r.state == state).count();
    let words = ["stable", "damped", "growing", "refused", "not converged"];
    let counts: Vec<String> = words.iter().map(|w| format!("{} {w}", count(w))).collect();
    section.text.push(format!(
        "{} steps a run, released from rest under its load. Explicit integrators are forced, one substep a step; beyond the \
         predicted limit the program refuses them unless asked. Runs: {}.",
        map.steps,
        counts.join(", ")
    ));
    let limits: Vec<&Row> = rows.iter().filter(|r| r.case == format!("limit-{}", map.name)).collect();
    if !limits.is_empty() {
        let head = ["integrator", &map.along, "predicted (s)", "observed (s)", "observed / predicted", "verdict"];
        let mut table = Table { caption: "Step limits".into(), head: head.map(String::from).to_vec(), rows: vec![] };
        for r in limits {
            let found = |key: &str| r.found.get(key).map_or_else(|| "-".into(), |v| short(*v));
            let mut cells = vec![r.method.clone(), short(value(r)), found("predicted"), found("observed")];
            cells.extend([found("ratio"), verdict(r)]);
            table.rows.push((cells, r.missed()));
        }
        section.tables.push(table);
    }
    (!of_map.is_empty() || !section.tables.is_empty()).then_some(section)
}

fn verdict(r: &Row) -> String {
    match r.passed {
        Some(false) => format!("missed: {}", r.note),
        Some(true) => "within".into(),
        None => "not judged".into(),
    }
}

fn balances(catalogue: &StabilityCatalogue, rows: &[Row]) -> Option<Section> {
    let mut section = Section { title: "Energy and momentum".into(), ..Section::default() };
    for balance in &catalogue.balance {
        let of: Vec<&Row> = rows.iter().filter(|r| r.case == balance.name).collect();
        let Some(first) = of.first() else { continue };
        let mut head = vec!["integrator".to_owned(), "dt (s)".into()];
        head.extend(first.found.keys().cloned());
        let what = match balance.of {
            Account::Energy => "energy from nothing (share of all work)",
            Account::Momentum => "change of momentum (share)",
            Account::AngularMomentum => "change of angular momentum (share)",
        };
        head.extend([what.into(), "allowed (1)".into(), "verdict".into()]);
        let mut table = Table { caption: balance.title.clone(), head, rows: vec![] };
        for r in &of {
            let mut cells = vec![r.method.clone(), short(r.dt)];
            cells.extend(first.found.keys().map(|k| r.found.get(k).map_or_else(|| "-".into(), |v| short(*v))));
            cells.push(r.error.map_or_else(|| "-".into(), short));
            cells.extend([short(balance.tolerance), verdict(r)]);
            table.rows.push((cells, r.missed()));
        }
        section.tables.push(table);
    }
    section.text.push(
        "Work in is what gravity, hands and led nodes do. What is neither kinetic nor elastic at the end was dissipated, some of \
         it by friction between tips and sheets; a body that holds more than was put in has made energy."
            .into(),
    );
    (!section.tables.is_empty()).then_some(section)
}

fn extremes(rows: &[Row]) -> Option<Section> {
    let of: Vec<&Row> = rows.iter().filter(|r| r.case == "extreme").collect();
    let head = ["what", "what happened", "energy from nothing (share)", "verdict and words"];
    let mut table = Table { caption: "One run each".into(), head: head.map(String::from).to_vec(), rows: vec![] };
    for r in &of {
        let excess = r.found.get("energy from nothing (share)").map_or_else(|| "-".into(), |v| short(*v));
        let word = if r.missed() { "missed" } else { "as it must" };
        let cells = vec![r.method.clone(), r.state.clone(), excess, format!("{word}; {}", r.note)];
        table.rows.push((cells, r.missed()));
    }
    let text = vec!["Values at the ends of what is allowed, and beyond.".into()];
    (!of.is_empty()).then(|| Section {
        title: "The extreme catalogue".into(),
        text,
        tables: vec![table],
        ..Section::default()
    })
}

fn coupling(rows: &[Row]) -> Option<Section> {
    let of: Vec<&Row> = rows.iter().filter(|r| r.case == "coupling").collect();
    let first = of.first()?;
    let damping = |r: &Row| r.at["device damping (N s/m)"];
    let (mut curves, shown) = (Vec::new(), damping(of[of.len() / 2]));
    let mut hands: Vec<&str> = of.iter().map(|r| r.method.as_str()).collect();
    hands.dedup();
    for hand in hands {
        let on: Vec<&&Row> = of.iter().filter(|r| r.method == hand && damping(r) == shown).collect();
        let points = |key: &str| on.iter().map(|r| (r.at["rate (Hz)"], r.found[key])).collect::<Vec<_>>();
        curves.push(Curve { name: hand.into(), points: points("observed"), large: vec![], theory: false });
        if hand == first.method || hand.contains("late") {
            let name = if hand.contains("late") { "bound, one sample late" } else { "bound of Colgate and Schenkel" };
            curves.push(Curve { name: name.into(), points: points("predicted"), large: vec![], theory: true });
        }
    }
    let picture = Lines {
        title: format!("Largest stable stiffness, device damping {shown} N s/m"),
        x: Axis::log("rate of the force (Hz)"),
        y: Axis::log("stiffness (N/m)"),
        curves,
    };
    let head = ["hand", "rate (Hz)", "damping (N s/m)", "bound (N/m)", "observed (N/m)", "observed / bound", "verdict"];
    let mut table = Table { caption: "Z-width".into(), head: head.map(String::from).to_vec(), rows: vec![] };
    for r in &of {
        let mut cells = vec![r.method.clone(), short(r.at["rate (Hz)"]), short(damping(r))];
        cells.extend(["predicted", "observed", "ratio"].map(|k| short(r.found[k])));
        cells.push(verdict(r));
        table.rows.push((cells, r.missed()));
    }
    let text = "A device of 45 g against a wall through a spring whose force is sampled and held. The bound is for any passive \
                hand: what holds a device with a hand of its own may be stiffer, none may fail below it.";
    let plots = vec![("coupling".into(), picture.svg())];
    Some(Section { title: "Coupling of hand and surface".into(), text: vec![text.into()], plots, tables: vec![table] })
}
