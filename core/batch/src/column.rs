//! Columns of a results table.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A column: name, unit and type of its values.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// Name, unique in the table.
    pub name: String,
    /// Unit symbol; `"1"` for dimensionless results, empty for identifiers, values that are not numbers, and parameters written without a unit.
    pub unit: String,
    /// Type of its values.
    #[serde(rename = "kind")]
    pub column_type: ColumnType,
}

/// Type of the values of a column. Names in files differ from those of the variants where `serde` renames them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColumnType {
    /// Whole numbers.
    Integer,
    /// Floating-point numbers.
    #[serde(rename = "number")]
    Float,
    /// True or false.
    #[serde(rename = "flag")]
    Boolean,
    /// UTF-8 strings.
    Text,
    /// Lists of floating-point numbers.
    #[serde(rename = "numbers")]
    FloatList,
}

impl Column {
    /// A column with a name, a unit and a type.
    pub(crate) fn new(name: &str, unit: &str, column_type: ColumnType) -> Self {
        Self { name: name.into(), unit: unit.into(), column_type }
    }

    /// Name followed by the unit, for headers of CSV files: `largest_force_N`, `young_kPa`.
    pub fn header(&self) -> String {
        let unit: String = self.unit.chars().map(|c| if matches!(c, ' ' | ',' | '"') { '_' } else { c }).collect();
        if unit.is_empty() || unit == "1" { self.name.clone() } else { format!("{}_{unit}", self.name) }
    }
}

/// A number as a cell; NaN and infinity, which JSON does not have, become an empty cell.
pub(crate) fn float_cell(value: f64) -> Value {
    serde_json::Number::from_f64(value).map_or(Value::Null, Value::Number)
}

/// A row as a JSON object on one line, with the cells in the order of the columns.
pub(crate) fn row_json(columns: &[Column], cells: &[Value]) -> String {
    debug_assert_eq!(columns.len(), cells.len(), "one cell for each column");
    let cell = |(column, value): (&Column, &Value)| format!("{}:{value}", Value::from(column.name.as_str()));
    let cells: Vec<String> = columns.iter().zip(cells).map(cell).collect();
    format!("{{{}}}", cells.join(","))
}
