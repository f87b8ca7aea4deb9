//! Parameters of plugins in a scene, checked against the plugin's declarations before any code of the plugin runs.

use super::source::{SceneError, Source};
use super::units::parse_quantity;
use pliant_host::{ParamInfo, ParamKind, ParamSettings, ParamValue, PluginInfo};
use std::collections::BTreeMap;
use toml::{Spanned, Value};

/// Converts the `given` values, by key, into settings of the parameters of a plugin.
///
/// # Errors
/// Fails for a key that the plugin does not declare, and for a value of a wrong type, with a unit of another quantity or out of range.
pub fn settings(
    source: &Source,
    info: &PluginInfo,
    given: &BTreeMap<String, Spanned<Value>>,
) -> Result<ParamSettings, SceneError> {
    let mut out = ParamSettings::new();
    for (key, value) in given {
        let at = |reason: String| source.error(value.span(), format!("{} `{}`: {reason}", info.kind.name(), info.id));
        let Some(index) = info.params.iter().position(|p| p.key == *key) else {
            let known: Vec<&str> = info.params.iter().map(|p| p.key.as_str()).collect();
            let known = if known.is_empty() { "none".into() } else { known.join(", ") };
            return Err(at(format!("no parameter `{key}`; allowed is {known}")));
        };
        let param = &info.params[index];
        let read = read(source, param, value.get_ref()).and_then(|v| param.check(&v).map(|()| v));
        out.push((index, read.map_err(|reason| at(format!("parameter `{key}`: {reason}")))?));
    }
    Ok(out)
}

/// Converts one value; the error is the reason.
fn read(source: &Source, param: &ParamInfo, value: &Value) -> Result<ParamValue, String> {
    let wrong = || {
        let article = if matches!(value, Value::Integer(_) | Value::Array(_)) { "an" } else { "a" };
        format!("{} is {article} {}; allowed is {}", shorten(value), value.type_str(), param.allowed())
    };
    match (&param.kind, value) {
        (ParamKind::Number { .. }, Value::String(text)) => parse_quantity(text, &param.unit).map(ParamValue::Number),
        (ParamKind::Number { .. }, value) => number(value).map(ParamValue::Number).ok_or_else(wrong),
        (ParamKind::Path, Value::String(text)) if !text.is_empty() => {
            let path = source.folder().join(text);
            let path = path.canonicalize().map_err(|e| format!("{}: {e}", path.display()))?;
            if !path.is_file() {
                return Err(format!("{}: not a regular file", path.display()));
            }
            let text = path.to_str().ok_or_else(|| format!("{}: allowed is a path in UTF-8", path.display()))?;
            Ok(ParamValue::Text(text.to_owned()))
        }
        (ParamKind::Choice { .. } | ParamKind::Text, Value::String(text)) => Ok(ParamValue::Text(text.clone())),
        (ParamKind::Table { columns }, Value::Array(rows)) => {
            let mut values = Vec::with_capacity(rows.len() * columns.len());
            for (i, row) in rows.iter().enumerate() {
                let expected = || format!("row {}: {}; allowed is [{}]", i + 1, shorten(row), columns.join(", "));
                let row = row.as_array().filter(|r| r.len() == columns.len()).ok_or_else(expected)?;
                for cell in row {
                    values.push(number(cell).ok_or_else(expected)?);
                }
            }
            Ok(ParamValue::Table { columns: columns.len(), values })
        }
        _ => Err(wrong()),
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|number| number as f64))
}

/// The value as text of at most 40 characters, for messages.
fn shorten(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() <= 40 { text } else { text.chars().take(37).chain("...".chars()).collect() }
}
