//! Columns of a results table.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// One column: its name, the unit of its values, and what they are.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// Name, unlike that of any other column of the table.
    pub name: String,
    /// Unit, as text; empty where there is none.
    pub unit: String,
    /// What its values are.
    pub kind: ColumnKind,
}

/// What the values of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColumnKind {
    /// Whole numbers.
    Integer,
    /// Numbers.
    Number,
    /// True or false.
    Flag,
    /// Texts.
    Text,
    /// Lists of numbers.
    Numbers,
}

impl Column {
    /// A column.
    pub(crate) fn new(name: &str, unit: &str, kind: ColumnKind) -> Self {
        Self { name: name.into(), unit: unit.into(), kind }
    }

    /// Name with the unit at its end, as headers of CSV files have it: `largest_force_N`, `young_kPa`.
    pub fn header(&self) -> String {
        let unit: String = self.unit.chars().map(|c| if matches!(c, ' ' | ',' | '"') { '_' } else { c }).collect();
        if unit.is_empty() || unit == "1" { self.name.clone() } else { format!("{}_{unit}", self.name) }
    }
}

/// A number as a cell; JSON has no NaN and no infinity, which become an empty cell.
pub(crate) fn number(value: f64) -> Value {
    serde_json::Number::from_f64(value).map_or(Value::Null, Value::Number)
}

/// A row as one line of JSON, cells in the order of the columns.
pub(crate) fn row_text(columns: &[Column], cells: &[Value]) -> String {
    let cell = |(column, value): (&Column, &Value)| format!("{}:{value}", Value::from(column.name.as_str()));
    let cells: Vec<String> = columns.iter().zip(cells).map(cell).collect();
    format!("{{{}}}", cells.join(","))
}
