//! Plots of columns of a table: lines or a heat map.

use crate::collect::Table;
use crate::column::Column;
use crate::error::BatchError;
use pliant_report::plot::{Axis, Curve, HeatMap, LinePlot};
use serde_json::Value;
use std::collections::BTreeMap;

/// Options of [`plot`].
#[derive(Clone, Debug)]
pub struct PlotOptions {
    /// Column along the horizontal axis.
    pub x: String,
    /// Column that is drawn.
    pub y: String,
    /// Column whose values have a line each, or in a heat map the column along the vertical axis.
    pub by: Option<String>,
    /// Whether to draw a heat map: `y` as colour over `x` and `by`.
    pub heat: bool,
}

/// Largest number of lines, so that they can be distinguished.
const MAX_LINES: usize = 21;
/// Largest number of values along each axis of a heat map.
const MAX_CELLS: usize = 64;
/// Ratio of the largest to the smallest value from which an axis is logarithmic.
const LOG_RATIO: f64 = 50.0;

/// Draws columns of a table as SVG. Of several rows with equal coordinates the mean is drawn. Failed runs and rows without a number are left
/// out.
///
/// # Errors
/// Fails for an unknown column, for one without numbers, and for too many lines or cells.
pub fn plot(table: &mut Table, options: &PlotOptions) -> Result<String, BatchError> {
    let columns = table.columns().to_vec();
    let (x, y) = (find(&columns, &options.x)?, find(&columns, &options.y)?);
    let by = options.by.as_deref().map(|by| find(&columns, by)).transpose()?;
    let status = find(&columns, "status")?;
    let mut points: BTreeMap<Group, BTreeMap<OrderedNumber, Mean>> = BTreeMap::new();
    table.for_each(|cells| {
        if let (Some(at), Some(value), Some("done")) = (cells[x].as_f64(), cells[y].as_f64(), cells[status].as_str()) {
            let group = by.map_or_else(Group::default, |by| Group::of(&cells[by]));
            points.entry(group).or_default().entry(OrderedNumber::new(at)).or_default().add(value);
        }
        Ok(())
    })?;
    if points.is_empty() {
        let text = format!("no row has numbers for both `{}` and `{}`", options.x, options.y);
        return Err(BatchError::Input(text));
    }
    match (options.heat, by) {
        (false, _) => lines(&columns, x, y, by, &points),
        (true, Some(by)) => heat_map(&columns, x, y, by, &points),
        (true, None) => Err(BatchError::Input("a heat map needs --by, the column along its vertical axis".into())),
    }
}

/// The common value of a group of rows; numbers are ordered by value and before texts.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Group {
    /// The number; infinity for a text.
    number: OrderedNumber,
    /// The value as text.
    text: String,
}

impl Group {
    /// The group of a value.
    fn of(value: &Value) -> Self {
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        Self { number: OrderedNumber::new(value.as_f64().unwrap_or(f64::INFINITY)), text }
    }
}

/// A number with a total order: its bits, transformed so that their order is that of the numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct OrderedNumber(i64);

impl OrderedNumber {
    /// From a number.
    fn new(number: f64) -> Self {
        Self(Self::flip(number.to_bits() as i64))
    }

    /// The number it was made from.
    fn number(self) -> f64 {
        f64::from_bits(Self::flip(self.0) as u64)
    }

    /// Inverts the magnitude bits of negative numbers, as [`f64::total_cmp`] does; its own inverse.
    fn flip(bits: i64) -> i64 {
        bits ^ (((bits >> 63) as u64) >> 1) as i64
    }
}

/// The mean of some values.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    /// Sum of the values.
    sum: f64,
    /// Number of values.
    count: f64,
}

impl Mean {
    /// Adds a value.
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1.0;
    }

    /// Mean of the values added.
    fn value(self) -> f64 {
        self.sum / self.count
    }
}

/// Means by group and x.
type Points = BTreeMap<Group, BTreeMap<OrderedNumber, Mean>>;

/// Index of a column, by its name with or without unit.
fn find(columns: &[Column], name: &str) -> Result<usize, BatchError> {
    let known = || columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>().join(", ");
    let index = columns.iter().position(|column| column.name == name || column.header() == name);
    index.ok_or_else(|| BatchError::Input(format!("no column `{name}`; allowed is {}", known())))
}

/// Name and unit of a column.
fn label(column: &Column) -> String {
    let (name, unit) = (column.name.replace('_', " "), &column.unit);
    if unit.is_empty() || unit == "1" { name } else { format!("{name} ({unit})") }
}

/// An axis for some values; logarithmic if their ratio exceeds [`LOG_RATIO`].
fn axis(column: &Column, values: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let label = label(column);
    if low > 0.0 && high > LOG_RATIO * low { Axis::log(&label) } else { Axis::linear(&label) }
}

/// Draws column `y` over column `x` as an SVG picture, with a line for each value of column `by`.
fn lines(columns: &[Column], x: usize, y: usize, by: Option<usize>, points: &Points) -> Result<String, BatchError> {
    if points.len() > MAX_LINES {
        let text = format!("{} lines; allowed are {MAX_LINES}. Draw a heat map with --heat", points.len());
        return Err(BatchError::Input(text));
    }
    let all = || points.values().flatten();
    let name = |group: &Group| match by {
        Some(by) => format!("{} {} {}", columns[by].name.replace('_', " "), group.text, columns[by].unit),
        None => label(&columns[y]),
    };
    let curve = |(group, points): (&Group, &BTreeMap<OrderedNumber, Mean>)| Curve {
        name: name(group).trim().to_owned(),
        points: points.iter().map(|(at, mean)| (at.number(), mean.value())).collect(),
        ..Curve::default()
    };
    let plot = LinePlot {
        title: format!("{} over {}", columns[y].name.replace('_', " "), columns[x].name.replace('_', " ")),
        x: axis(&columns[x], all().map(|(at, _)| at.number())),
        y: axis(&columns[y], all().map(|(_, mean)| mean.value())),
        curves: points.iter().map(curve).collect(),
    };
    Ok(plot.svg())
}

/// Draws a heat map.
fn heat_map(columns: &[Column], x: usize, y: usize, by: usize, points: &Points) -> Result<String, BatchError> {
    let mut numbers: Vec<f64> = points.values().flat_map(|row| row.keys().map(|x| x.number())).collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    if numbers.len() > MAX_CELLS || points.len() > MAX_CELLS {
        let text = format!("{} x {} cells; allowed are {MAX_CELLS} x {MAX_CELLS}", numbers.len(), points.len());
        return Err(BatchError::Input(text));
    }
    let row = |row: &BTreeMap<OrderedNumber, Mean>| {
        numbers.iter().map(|x| row.get(&OrderedNumber::new(*x)).map(|mean| mean.value())).collect::<Vec<_>>()
    };
    let map = HeatMap {
        title: label(&columns[y]),
        x: label(&columns[x]),
        y: label(&columns[by]),
        columns: numbers.clone(),
        rows: points.keys().map(|group| group.text.clone()).collect(),
        values: points.values().map(row).collect(),
    };
    Ok(map.svg())
}
