//! Columns of a results table.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A column: name, unit and type of its values.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// Name, unique in the table.
    pub name: String,
    /// Unit as text; empty for values that are not numbers.
    pub unit: String,
    /// Type of its values.
    pub kind: ColumnKind,
}

/// Type of the values of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColumnKind {
    /// Whole numbers.
    Integer,
    /// Floating-point numbers.
    Number,
    /// True or false.
    Flag,
    /// Texts, in UTF-8.
    Text,
    /// Lists of numbers.
    Numbers,
}

impl Column {
    /// A column with a name, a unit and a type.
    pub(crate) fn new(name: &str, unit: &str, kind: ColumnKind) -> Self {
        Self { name: name.into(), unit: unit.into(), kind }
    }

    /// Name followed by the unit, for headers of CSV files: `largest_force_N`, `young_kPa`.
    pub fn header(&self) -> String {
        let unit: String = self.unit.chars().map(|c| if matches!(c, ' ' | ',' | '"') { '_' } else { c }).collect();
        if unit.is_empty() || unit == "1" { self.name.clone() } else { format!("{}_{unit}", self.name) }
    }
}

/// A number as a cell; NaN and infinity, which JSON does not have, become an empty cell.
pub(crate) fn number(value: f64) -> Value {
    serde_json::Number::from_f64(value).map_or(Value::Null, Value::Number)
}

/// A row as a JSON object on one line, with the cells in the order of the columns.
pub(crate) fn row_text(columns: &[Column], cells: &[Value]) -> String {
    let cell = |(column, value): (&Column, &Value)| format!("{}:{value}", Value::from(column.name.as_str()));
    let cells: Vec<String> = columns.iter().zip(cells).map(cell).collect();
    format!("{{{}}}", cells.join(","))
}
