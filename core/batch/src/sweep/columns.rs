//! Columns of the table of a sweep, determined before any run.

use super::Sweep;
use crate::column::{Column, ColumnType};
use crate::execute::SUMMARY;
use pliant_engine::plan::{Plan, Probe};
use pliant_engine::scene::{Scene, SceneError, Source, load_text};
use pliant_record::{TracedTool, trace_columns};
use std::collections::BTreeMap;

/// Columns of the outcome of a run.
pub(super) const OUTCOME: [&str; 3] = ["status", "class", "message"];

/// Sets the columns of a sweep.
///
/// # Errors
/// Fails for a base scene that is invalid, an unknown column of the trace and two columns of one name.
pub(super) fn find(sweep: &mut Sweep, source: &Source) -> Result<(), SceneError> {
    let plans = plans(sweep)?;
    let mut columns = given(sweep);
    sweep.given = columns.len();
    columns.extend(OUTCOME.map(|name| Column::new(name, "", ColumnType::Text)));
    for name in &sweep.keep.summary {
        let column = SUMMARY.iter().find(|column| column.name == *name).expect("checked when it was read");
        columns.push(Column::new(name, column.unit, column.column_type));
    }
    if sweep.keep.probes {
        columns.extend(probes(&plans));
    }
    for name in &sweep.keep.trace {
        check_trace(name, &plans, source)?;
        columns.push(trace_column(name));
    }
    if sweep.keep.meshes {
        columns.push(Column::new("mesh", "", ColumnType::Text));
    }
    for (at, column) in columns.iter().enumerate() {
        if columns[..at].iter().any(|other| other.name == column.name) {
            let text = format!("two columns have the name `{}`; give the parameter another `name`", column.name);
            return Err(source.whole(text));
        }
    }
    sweep.columns = columns;
    Ok(())
}

/// Columns of the index, the key, and the inputs that vary.
fn given(sweep: &Sweep) -> Vec<Column> {
    let mut columns = vec![Column::new("edit", "", ColumnType::Integer), Column::new("key", "", ColumnType::Text)];
    if sweep.scenes.len() > 1 {
        columns.push(Column::new("scene", "", ColumnType::Text));
    }
    if !sweep.models.is_empty() {
        columns.push(Column::new("model", "", ColumnType::Text));
    }
    let parameters: Vec<_> = sweep.axes.iter().flat_map(|axis| &axis.parameters).collect();
    let end = |path: &str| path.rsplit('.').next().unwrap_or(path).to_owned();
    let mut ends: BTreeMap<String, usize> = BTreeMap::new();
    for path in parameters.iter().filter_map(|p| p.path.as_deref()) {
        *ends.entry(end(path)).or_default() += 1;
    }
    for parameter in parameters {
        let path = parameter.path.as_deref().unwrap_or_default();
        // The end of the path, unless that of another parameter is the same.
        let short = if ends.get(&end(path)) == Some(&1) { end(path) } else { path.to_owned() };
        columns.push(Column::new(&parameter.name.clone().unwrap_or(short), &parameter.unit, parameter.column_type));
    }
    columns
}

/// A base scene with the settings of a run, and its plan.
struct Planned {
    /// Scene with the settings of the run.
    scene: Scene,
    /// Plan of that scene.
    plan: Plan,
}

/// Plans of all base scenes, each with the settings of its first run, or of its last if the first is invalid. A single invalid run is a row
/// of the table, so it is no error here.
fn plans(sweep: &Sweep) -> Result<Vec<Planned>, SceneError> {
    let per_scene = sweep.edits / sweep.scenes.len() as u64;
    let plan = |index: u64| {
        let edit = sweep.edit(index);
        let base = sweep.base(&edit);
        let (scene, source) = load_text(&base.path, base.text.clone(), &edit.settings)?;
        let plan = Plan::new(&scene, &source)?;
        Ok(Planned { scene, plan })
    };
    let of_scene = |i: u64| {
        plan(i * per_scene).or_else(|first: SceneError| plan((i + 1) * per_scene - 1).map_err(|_: SceneError| first))
    };
    (0..sweep.scenes.len() as u64).map(of_scene).collect()
}

/// A column for each name of a probe, in the order of the scenes.
fn probes(plans: &[Planned]) -> Vec<Column> {
    let mut columns: Vec<Column> = Vec::new();
    let all: Vec<&Probe> = plans.iter().flat_map(|planned| &planned.plan.probes).collect();
    for probe in all {
        if columns.iter().all(|column| column.name != probe.name) {
            columns.push(Column::new(&probe.name, probe.quantity.unit, ColumnType::Float));
        }
    }
    columns
}

/// Checks that a base scene has a column of the trace.
fn check_trace(name: &str, plans: &[Planned], source: &Source) -> Result<(), SceneError> {
    let columns = |planned: &Planned| {
        let tools = planned.plan.tools.iter().enumerate().map(|(at, &tool)| TracedTool {
            name: planned.scene.tool[tool].name.get_ref(),
            has_torque: planned.plan.has_torque(at),
        });
        trace_columns(tools)
    };
    let known: Vec<String> = plans.iter().flat_map(columns).filter(|column| column != "step_seconds").collect();
    if known.iter().any(|column| column == name) {
        return Ok(());
    }
    Err(source.whole(format!("`keep.trace`: no column `{name}` in a trace; allowed is {}", known.join(", "))))
}

/// A column of the trace: its unit is the end of its name.
fn trace_column(name: &str) -> Column {
    let units = ["s", "m", "N", "Nm", "J"];
    let (stem, unit) = name.rsplit_once('_').filter(|(_, unit)| units.contains(unit)).unwrap_or((name, ""));
    let unit = if unit == "Nm" { "N m" } else { unit };
    let column_type = if name.ends_with(".contact") { ColumnType::Text } else { ColumnType::FloatList };
    Column::new(stem, unit, column_type)
}
