//! The sections of a stability report.

use super::catalogue::{ConservationCase, ConservedQuantity, StabilityCatalogue, StabilityMap};
use super::state::RunState;
use crate::plot::{Axis, Curve, LinePlot, StateMap, format_short};
use crate::row::Row;
use crate::section::{Section, Table};

/// A section for each map, then balances, extremes and coupling, as far as there are rows of them.
pub(super) fn stability_sections(catalogue: &StabilityCatalogue, rows: &[Row]) -> Vec<Section> {
    let mut out: Vec<Section> = catalogue.maps.iter().filter_map(|map| map_section(map, rows)).collect();
    out.extend(balance_section(&catalogue.balances, rows));
    out.extend(extreme_section(rows));
    out.extend(coupling_section(rows));
    out
}

/// Maps of states by integrator, and the table of step limits.
fn map_section(map: &StabilityMap, rows: &[Row]) -> Option<Section> {
    let of_map: Vec<&Row> = rows.iter().filter(|r| r.case == map.name).collect();
    let value = |r: &Row| r.parameters.get(&map.parameter).copied().unwrap_or(f64::NAN);
    let columns = sorted(of_map.iter().map(|r| value(r)));
    let steps = sorted(of_map.iter().map(|r| r.dt));
    let mut section = Section { title: format!("{}: {}", map.name, map.title), ..Section::default() };
    for integrator in &map.integrators {
        let at = |x: f64, dt: f64| of_map.iter().find(|r| r.method == *integrator && value(r) == x && r.dt == dt);
        let states =
            |dt: &f64| columns.iter().map(|x| at(*x, *dt).map_or(String::new(), |r| r.state.clone())).collect();
        let limit = |x: &f64| steps.iter().find_map(|dt| at(*x, *dt)?.results.get("predicted").copied());
        let picture = StateMap {
            title: format!("{}: {integrator}", map.name),
            x: map.parameter.clone(),
            y: "step (s)".into(),
            columns: columns.clone(),
            rows: steps.clone(),
            states: steps.iter().map(states).collect(),
            predicted: columns.iter().map(limit).collect(),
        };
        section.plots.push((format!("{}-{integrator}", map.name), picture.svg()));
    }
    let states = [RunState::Stable, RunState::Damped, RunState::Growing, RunState::Refused, RunState::NotConverged];
    let count = |name: &str| of_map.iter().filter(|r| r.state == name).count();
    let counts: Vec<String> = states.iter().map(|s| format!("{} {}", count(s.name()), s.name())).collect();
    section.text.push(format!(
        "{} steps a run, released from rest under its load. Explicit integrators are forced, one substep a step; beyond the \
         predicted limit the program refuses them unless asked. Runs: {}.",
        map.step_count,
        counts.join(", ")
    ));
    section.tables.extend(limit_table(map, rows));
    (!of_map.is_empty() || !section.tables.is_empty()).then_some(section)
}

/// Predicted and observed step limits of a map, if they were searched for.
fn limit_table(map: &StabilityMap, rows: &[Row]) -> Option<Table> {
    let limits: Vec<&Row> = rows.iter().filter(|r| r.case == format!("limit-{}", map.name)).collect();
    let head = ["integrator", &map.parameter, "predicted (s)", "observed (s)", "observed / predicted", "verdict"];
    let mut table = Table::new("Step limits", &head);
    for r in &limits {
        let result = |key: &str| r.results.get(key).map_or_else(|| "-".into(), |v| format_short(*v));
        let value = r.parameters.get(&map.parameter).copied().unwrap_or(f64::NAN);
        let mut cells = vec![r.method.clone(), format_short(value), result("predicted"), result("observed")];
        cells.extend([result("ratio"), verdict(r)]);
        table.push(cells, r.failed());
    }
    (!limits.is_empty()).then_some(table)
}

/// Distinct values in ascending order.
fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Text on whether a row meets its criterion.
fn verdict(r: &Row) -> String {
    match r.passed {
        Some(false) => format!("failed: {}", r.note),
        Some(true) => "within".into(),
        None => "not judged".into(),
    }
}

/// A table for each balanced run.
fn balance_section(cases: &[ConservationCase], rows: &[Row]) -> Option<Section> {
    let mut section = Section { title: "Energy and momentum".into(), ..Section::default() };
    for case in cases {
        let of: Vec<&Row> = rows.iter().filter(|r| r.case == case.name).collect();
        let Some(first) = of.first() else { continue };
        let error = match case.quantity {
            ConservedQuantity::Energy => "energy from nothing (share of all work)",
            ConservedQuantity::Momentum => "change of momentum (share)",
            ConservedQuantity::AngularMomentum => "change of angular momentum (share)",
        };
        let mut head = vec!["integrator", "dt (s)"];
        head.extend(first.results.keys().map(String::as_str));
        head.extend([error, "allowed (1)", "verdict"]);
        let mut table = Table::new(case.title.clone(), &head);
        for r in &of {
            let mut cells = vec![r.method.clone(), format_short(r.dt)];
            let result = |key| r.results.get(key).map_or_else(|| "-".into(), |v| format_short(*v));
            cells.extend(first.results.keys().map(result));
            cells.push(r.error.map_or_else(|| "-".into(), format_short));
            cells.extend([format_short(case.tolerance), verdict(r)]);
            table.push(cells, r.failed());
        }
        section.tables.push(table);
    }
    section.text.push(
        "Work in is done by gravity, hands and kinematic nodes. What is neither kinetic nor elastic at the end was dissipated, in \
         part by friction between tips and sheets. A body that holds more than was put in has gained energy from the \
         integration: energy from nothing."
            .into(),
    );
    (!section.tables.is_empty()).then_some(section)
}

/// The table of extreme values.
fn extreme_section(rows: &[Row]) -> Option<Section> {
    let of: Vec<&Row> = rows.iter().filter(|r| r.case == "extreme").collect();
    let mut table =
        Table::new("One run each", &["what", "what happened", "energy from nothing (share)", "verdict and words"]);
    for r in &of {
        let excess = r.results.get("energy from nothing (share)").map_or_else(|| "-".into(), |v| format_short(*v));
        let word = if r.failed() { "failed" } else { "met" };
        table.push(vec![r.method.clone(), r.state.clone(), excess, format!("{word}; {}", r.note)], r.failed());
    }
    let text = vec!["Values at the ends of what is allowed, and beyond.".into()];
    (!of.is_empty()).then(|| Section {
        title: "The extreme catalogue".into(),
        text,
        tables: vec![table],
        ..Section::default()
    })
}

/// The largest stable stiffness of the coupling over the rate of the force, beside the bound.
fn coupling_section(rows: &[Row]) -> Option<Section> {
    let of: Vec<&Row> = rows.iter().filter(|r| r.case == "coupling").collect();
    let first = of.first()?;
    let damping = |r: &Row| r.parameters["device damping (N s/m)"];
    let (mut curves, shown) = (Vec::new(), damping(of[of.len() / 2]));
    let mut hands: Vec<&str> = of.iter().map(|r| r.method.as_str()).collect();
    hands.dedup();
    for hand in hands {
        let on: Vec<&&Row> = of.iter().filter(|r| r.method == hand && damping(r) == shown).collect();
        let points = |key: &str| on.iter().map(|r| (r.parameters["rate (Hz)"], r.results[key])).collect::<Vec<_>>();
        curves.push(Curve { name: hand.into(), points: points("observed"), ..Curve::default() });
        if hand == first.method || hand.contains("late") {
            let name = if hand.contains("late") { "bound, one sample late" } else { "bound of Colgate and Schenkel" };
            curves.push(Curve { name: name.into(), points: points("predicted"), theory: true, ..Curve::default() });
        }
    }
    let picture = LinePlot {
        title: format!("Largest stable stiffness, device damping {shown} N s/m"),
        x: Axis::log("rate of the force (Hz)"),
        y: Axis::log("stiffness (N/m)"),
        curves,
    };
    let head = ["hand", "rate (Hz)", "damping (N s/m)", "bound (N/m)", "observed (N/m)", "observed / bound", "verdict"];
    let mut table = Table::new("Z-width", &head);
    for r in &of {
        let mut cells = vec![r.method.clone(), format_short(r.parameters["rate (Hz)"]), format_short(damping(r))];
        cells.extend(["predicted", "observed", "ratio"].map(|key| format_short(r.results[key])));
        cells.push(verdict(r));
        table.push(cells, r.failed());
    }
    let text = "A device of 45 g against a wall through a spring whose force is sampled and held. The bound holds for any passive \
                hand: with a certain hand the coupling may be stiffer, with none may it be unstable below the bound.";
    let plots = vec![("coupling".into(), picture.svg())];
    Some(Section { title: "Coupling of hand and surface".into(), text: vec![text.into()], plots, tables: vec![table] })
}
