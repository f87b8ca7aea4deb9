//! Values of parameters: numbers with or without a unit, and other values of a scene.

use crate::column::ColumnType;
use serde_json::Value as Cell;
use toml::Value;

/// A value of a parameter: its text in the scene, and its cell in the table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ParameterValue {
    /// The value as TOML.
    pub(crate) setting: String,
    /// A number without its unit, a text or a flag.
    pub(crate) cell: Cell,
}

/// A number with a unit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Measure {
    /// Number before the unit.
    pub(super) number: f64,
    /// The unit as text; empty without one.
    pub(super) unit: String,
}

impl Measure {
    /// The number and unit of a TOML value; `None` if it is something else.
    pub(super) fn of(value: &Value) -> Option<Self> {
        match value {
            Value::Integer(i) => Some(Self { number: *i as f64, unit: String::new() }),
            Value::Float(f) if f.is_finite() => Some(Self { number: *f, unit: String::new() }),
            Value::String(text) => {
                let text = text.trim();
                let ends = text.char_indices().map(|(at, c)| at + c.len_utf8()).rev();
                let parse = |end: usize| text[..end].trim().parse::<f64>().ok().filter(|n| n.is_finite());
                let (end, number) = ends.filter_map(|end| Some((end, parse(end)?))).next()?;
                let unit = text[end..].trim().to_owned();
                (!unit.is_empty()).then_some(Self { number, unit })
            }
            Value::Float(_) | Value::Boolean(_) | Value::Datetime(_) | Value::Array(_) | Value::Table(_) => None,
        }
    }

    /// The value of a parameter.
    pub(super) fn value(&self) -> ParameterValue {
        let Self { number, unit } = self;
        let setting = match unit.is_empty() {
            // Whole numbers have no fraction, as integer parameters need.
            true => format!("{number}"),
            false => format!("\"{number} {unit}\""),
        };
        ParameterValue { setting, cell: number_cell(*number) }
    }
}

/// A number as a cell; whole numbers become integers.
fn number_cell(number: f64) -> Cell {
    /// Whole numbers below this are exact in `f64`.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    if number.fract() == 0.0 && number.abs() < EXACT { Cell::from(number as i64) } else { Cell::from(number) }
}

/// Values of a parameter with their common unit and type.
pub(super) struct Listed {
    /// Values as written, in order.
    pub(super) values: Vec<ParameterValue>,
    /// Their unit; empty without one.
    pub(super) unit: String,
    /// Type of the column that shows them.
    pub(super) column_type: ColumnType,
}

/// The values of a list. Numbers of one unit make a column of floating-point numbers in that unit, Booleans one of Booleans, other values one of strings.
pub(super) fn listed(list: &[Value]) -> Listed {
    let measures: Option<Vec<Measure>> = list.iter().map(Measure::of).collect();
    if let Some(measures) = measures
        && let Some(first) = measures.first()
        && measures.iter().all(|m| m.unit == first.unit)
    {
        let values = list.iter().zip(&measures);
        let values = values.map(|(v, m)| ParameterValue { setting: v.to_string(), cell: number_cell(m.number) });
        return Listed { values: values.collect(), unit: first.unit.clone(), column_type: ColumnType::Float };
    }
    let flags = list.iter().all(|v| matches!(v, Value::Boolean(_)));
    let cell = |value: &Value| match value {
        Value::Boolean(flag) if flags => Cell::from(*flag),
        Value::String(text) => Cell::from(text.as_str()),
        Value::Integer(_)
        | Value::Float(_)
        | Value::Boolean(_)
        | Value::Datetime(_)
        | Value::Array(_)
        | Value::Table(_) => Cell::from(value.to_string()),
    };
    let values = list.iter().map(|v| ParameterValue { setting: v.to_string(), cell: cell(v) }).collect();
    Listed { values, unit: String::new(), column_type: if flags { ColumnType::Boolean } else { ColumnType::Text } }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measure(value: impl Into<Value>) -> Option<(f64, String)> {
        Measure::of(&value.into()).map(|m| (m.number, m.unit))
    }

    #[test]
    fn a_number_and_its_unit_are_told_apart() {
        assert_eq!(measure("10 kPa"), Some((10.0, "kPa".into())));
        assert_eq!(measure("1e-3m"), Some((1e-3, "m".into())));
        assert_eq!(measure("2.5 N s/m"), Some((2.5, "N s/m".into())));
        assert_eq!(measure(3), Some((3.0, String::new())));
        assert_eq!((measure("cloth"), measure("12"), measure(f64::NAN)), (None, None, None));
    }

    #[test]
    fn lists_of_one_unit_are_numbers_and_others_texts() {
        let list = |texts: &[&str]| listed(&texts.iter().map(|t| Value::from(*t)).collect::<Vec<_>>());
        let same = list(&["5 kPa", "10 kPa"]);
        assert_eq!(
            (same.unit.as_str(), same.column_type, &same.values[1].cell),
            ("kPa", ColumnType::Float, &Cell::from(10))
        );
        assert_eq!(same.values[0].setting, "\"5 kPa\"");
        assert_eq!(list(&["5 kPa", "1 MPa"]).column_type, ColumnType::Text);
        assert_eq!(list(&["denim", "silk"]).values[1].cell, Cell::from("silk"));
    }
}
