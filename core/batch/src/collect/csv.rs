//! Writing of a table as comma-separated values (RFC 4180, with line feeds).

use super::Table;
use crate::column::Column;
use crate::error::BatchError;
use serde_json::Value;
use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

/// Writes a header with units and a line for each row.
pub(super) fn write(table: &mut Table, out: &mut impl Write) -> Result<(), BatchError> {
    let io = |source| BatchError::io(Path::new("the table"), source);
    let names: Vec<String> = table.columns().iter().map(|column: &Column| quoted(&column.header()).into()).collect();
    writeln!(out, "{}", names.join(",")).map_err(io)?;
    table.for_each(|cells| {
        let cells: Vec<String> = cells.iter().map(cell).collect();
        writeln!(out, "{}", cells.join(",")).map_err(io)
    })
}

/// The text of a cell; empty without a value.
fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => quoted(text).into_owned(),
        Value::Array(_) | Value::Object(_) => quoted(&value.to_string()).into_owned(),
        Value::Bool(_) | Value::Number(_) => value.to_string(),
    }
}

/// A text, in quotes if it needs them.
fn quoted(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r']) {
        Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(text)
    }
}
