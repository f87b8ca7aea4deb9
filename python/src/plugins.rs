//! What there is: plugins with their parameters, edit kinds, and quantities of probes.

use super::failure::{Failure, contained};
use super::open::OpenOptions;
use pliant_editor::{SOLIDS, SolidPreset, device_choices};
use pliant_engine::edit::Command;
use pliant_engine::probe::QUANTITIES;
use pliant_host::{Library, ParamInfo, ParamKind, PluginKind, choice_sources};
use pyo3::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Every plugin that is found, as JSON. A library that cannot be opened has an `error` in the place of its plugins.
#[pyfunction]
pub fn plugins(py: Python<'_>, options: OpenOptions) -> PyResult<String> {
    let list = || -> Result<String, Failure> {
        let mut rows = Vec::new();
        for found in options.search()?.scan() {
            match Library::open(&found.path) {
                Ok(library) => {
                    for plugin in library.plugins() {
                        let is_material = plugin.kind == PluginKind::Material;
                        let sources = is_material.then(|| choice_sources(library, &plugin.id)).transpose()?;
                        let sources = sources.unwrap_or_default();
                        let sourced = |index: usize| {
                            let of = sources.iter().filter(move |s| s.param == index);
                            of.map(|s| (s.choice, s.source.clone())).collect::<BTreeMap<_, _>>()
                        };
                        let params = plugin.params.iter().enumerate();
                        rows.push(json!({
                            "kind": plugin.kind.name(), "id": plugin.id, "name": plugin.name, "version": plugin.version,
                            "summary": plugin.summary, "path": found.path.display().to_string(),
                            "params": params.map(|(i, param)| param_json(param, &sourced(i))).collect::<Vec<_>>(),
                        }));
                    }
                }
                Err(error) => {
                    rows.push(json!({ "path": found.path.display().to_string(), "error": error.to_string() }))
                }
            }
        }
        Ok(Value::from(rows).to_string())
    };
    Ok(py.detach(|| contained(list))?)
}

/// Folders of plugins that are not searched because other users could put plugins into them, a sentence each.
#[pyfunction]
pub fn skipped_plugin_folders(options: OpenOptions) -> PyResult<Vec<String>> {
    Ok(options.search()?.warnings().to_vec())
}

fn param_json(param: &ParamInfo, sources: &BTreeMap<usize, String>) -> Value {
    let mut row = json!({ "key": param.key, "unit": param.unit, "summary": param.summary });
    match &param.kind {
        ParamKind::Number { min, max, default } => {
            row["type"] = "number".into();
            (row["min"], row["max"], row["default"]) = (json!(min), json!(max), json!(default));
        }
        ParamKind::Choice { choices, default } => {
            row["type"] = "choice".into();
            (row["choices"], row["default"]) = (json!(choices), json!(choices[*default]));
            let named = sources.iter().filter_map(|(choice, source)| Some((choices.get(*choice)?, source)));
            row["sources"] = json!(named.collect::<BTreeMap<_, _>>());
        }
        ParamKind::Text => row["type"] = "text".into(),
        ParamKind::Path => row["type"] = "path".into(),
        ParamKind::Table { columns } => {
            row["type"] = "table".into();
            row["columns"] = json!(columns);
        }
    }
    row
}

/// A solid material: name, Young's modulus (Pa), Poisson's ratio, density (kg/m^3), damping time (s), where these come from, and yield
/// strain, hardening and flow time (s) of one that flows.
type SolidRow = (&'static str, f64, f64, f64, f64, &'static str, Option<(f64, f64, f64)>);

/// Solid materials by name.
#[pyfunction]
pub fn solids() -> Vec<SolidRow> {
    let flow = |s: &SolidPreset| s.flow.map(|f| (f.yield_strain, f.hardening, f.flow_time));
    SOLIDS.iter().map(|s| (s.name, s.young, s.poisson, s.density, s.damping_time, s.source, flow(s))).collect()
}

/// Names of the edit kinds, each with a sentence on what it does.
#[pyfunction]
pub fn edit_kinds() -> Vec<(&'static str, &'static str)> {
    Command::names().collect()
}

/// Edit kinds with a strength, each with its SI unit (empty for a factor) and its default.
#[pyfunction]
pub fn edit_strengths() -> Vec<(&'static str, &'static str, f64)> {
    let strength = |name: &'static str| match Command::find(name)? {
        Command::Tool(kind) => kind.strength().map(|strength| (name, strength.unit, strength.default)),
        Command::Undo | Command::Redo => None,
    };
    Command::names().filter_map(|(name, _)| strength(name)).collect()
}

/// Names of the plugins of devices that can have the hand.
#[pyfunction]
pub fn devices(py: Python<'_>, options: OpenOptions) -> PyResult<Vec<String>> {
    let list = || Ok(device_choices(&options.search()?).into_iter().map(|choice| choice.name).collect());
    Ok(py.detach(|| contained(list))?)
}

/// The edit kind that does the opposite of another, if the engine has it.
#[pyfunction]
pub fn opposite_kind(kind: &str) -> Option<&'static str> {
    pliant_editor::opposite_kind(kind)
}

/// Names of the quantities a probe measures, each with a sentence.
#[pyfunction]
pub fn quantities() -> Vec<(&'static str, &'static str)> {
    QUANTITIES.iter().map(|quantity| (quantity.name, quantity.summary)).collect()
}
