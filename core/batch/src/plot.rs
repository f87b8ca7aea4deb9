//! Columns of a table as a picture: lines, or a heat map.

use crate::collect::Table;
use crate::column::Column;
use crate::error::BatchError;
use pliant_report::plot::{Axis, Curve, HeatMap, LinePlot};
use serde_json::Value;
use std::collections::BTreeMap;

/// What is drawn.
#[derive(Clone, Debug)]
pub struct PlotOptions {
    /// Column along the horizontal axis.
    pub x: String,
    /// Column that is drawn.
    pub y: String,
    /// Column whose values have a line each, or of a heat map the column along the vertical axis.
    pub by: Option<String>,
    /// Draw a heat map: `y` as colour over `x` and `by`.
    pub heat: bool,
}

/// Largest number of lines that can be told apart.
const MAX_LINES: usize = 21;
/// Largest number of values along each axis of a heat map.
const MAX_CELLS: usize = 64;
/// Ratio of the largest to the smallest value from which an axis is logarithmic.
const LOG_RATIO: f64 = 50.0;

/// Draws columns of a table as SVG. Where several rows share a place their mean is drawn. Failed edits, and rows without a number, are left
/// out.
///
/// # Errors
/// A column that is not there or has no numbers, more lines or cells than can be told apart.
pub fn plot(table: &mut Table, options: &PlotOptions) -> Result<String, BatchError> {
    let columns = table.columns().to_vec();
    let (x, y) = (find(&columns, &options.x)?, find(&columns, &options.y)?);
    let by = options.by.as_deref().map(|by| find(&columns, by)).transpose()?;
    let status = find(&columns, "status")?;
    let mut points: BTreeMap<Group, BTreeMap<Place, Mean>> = BTreeMap::new();
    table.for_each(|cells| {
        if let (Some(at), Some(value), Some("done")) = (cells[x].as_f64(), cells[y].as_f64(), cells[status].as_str()) {
            let group = by.map_or_else(Group::default, |by| Group::of(&cells[by]));
            points.entry(group).or_default().entry(Place::of(at)).or_default().add(value);
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

/// The value that a group of rows shares, numbers in their order and before texts.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Group {
    place: Place,
    text: String,
}

impl Group {
    fn of(value: &Value) -> Self {
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        Self { place: Place::of(value.as_f64().unwrap_or(f64::INFINITY)), text }
    }
}

/// A place along an axis: the bits of its number, in the order of numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Place(i64);

impl Place {
    fn of(number: f64) -> Self {
        Self(Self::turn(number.to_bits() as i64))
    }

    fn number(self) -> f64 {
        f64::from_bits(Self::turn(self.0) as u64)
    }

    /// Turns the magnitude of negative numbers round, as [`f64::total_cmp`] does; twice is nothing.
    fn turn(bits: i64) -> i64 {
        bits ^ (((bits >> 63) as u64) >> 1) as i64
    }
}

/// The mean of some values.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1.0;
    }

    fn value(self) -> f64 {
        self.sum / self.count
    }
}

type Points = BTreeMap<Group, BTreeMap<Place, Mean>>;

/// The place of a column.
fn find(columns: &[Column], name: &str) -> Result<usize, BatchError> {
    let known = || columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>().join(", ");
    let place = columns.iter().position(|column| column.name == name || column.header() == name);
    place.ok_or_else(|| BatchError::Input(format!("no column `{name}`; allowed is {}", known())))
}

/// Name and unit of a column.
fn label(column: &Column) -> String {
    let (name, unit) = (column.name.replace('_', " "), &column.unit);
    if unit.is_empty() || unit == "1" { name } else { format!("{name} ({unit})") }
}

/// An axis for some values, logarithmic where they span decades.
fn axis(column: &Column, values: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let label = label(column);
    if low > 0.0 && high > LOG_RATIO * low { Axis::log(&label) } else { Axis::linear(&label) }
}

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
    let curve = |(group, points): (&Group, &BTreeMap<Place, Mean>)| Curve {
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

fn heat_map(columns: &[Column], x: usize, y: usize, by: usize, points: &Points) -> Result<String, BatchError> {
    let mut places: Vec<f64> = points.values().flat_map(|row| row.keys().map(|place| place.number())).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    if places.len() > MAX_CELLS || points.len() > MAX_CELLS {
        let text = format!("{} x {} cells; allowed are {MAX_CELLS} x {MAX_CELLS}", places.len(), points.len());
        return Err(BatchError::Input(text));
    }
    let row = |row: &BTreeMap<Place, Mean>| {
        places.iter().map(|place| row.get(&Place::of(*place)).map(|mean| mean.value())).collect::<Vec<_>>()
    };
    let map = HeatMap {
        title: label(&columns[y]),
        x: label(&columns[x]),
        y: label(&columns[by]),
        columns: places.clone(),
        rows: points.keys().map(|group| group.text.clone()).collect(),
        values: points.values().map(row).collect(),
    };
    Ok(map.svg())
}
