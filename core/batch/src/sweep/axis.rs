//! Axes of a sweep: lists of points, each with values of some parameters.

use super::file::{AxisFile, Method, ParameterFile, RangeFile, RepeatFile, SampleFile, SampledFile};
use super::quantity::{Listed, Measure, ParameterValue, listed};
use super::random::Random;
use crate::column::ColumnType;
use pliant_engine::scene::{SceneError, Source};
use serde_json::Value as Cell;
use std::ops::Range;
use toml::Spanned;

/// A parameter of an axis.
#[derive(Clone, Debug)]
pub(crate) struct Parameter {
    /// Path in the scene; `None` for a parameter that has a column alone.
    pub(crate) path: Option<String>,
    /// Name of its column; `None` for the end of the path.
    pub(crate) name: Option<String>,
    /// Unit of its values.
    pub(crate) unit: String,
    /// Type of its values.
    pub(crate) column_type: ColumnType,
}

/// An axis of a sweep: parameters that vary together, with their values at each point.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    /// Its parameters (p).
    pub(crate) parameters: Vec<Parameter>,
    /// Values at each point (n x p).
    pub(crate) points: Vec<Vec<ParameterValue>>,
}

/// Largest number of points of an axis, which are in memory.
const MAX_POINTS: u64 = 10_000_000;

impl Axis {
    /// The axis of a sweep file.
    ///
    /// # Errors
    /// The first error, with its line.
    pub(super) fn from_file(axis: &Spanned<AxisFile>, source: &Source) -> Result<Self, SceneError> {
        let (file, span) = (axis.get_ref(), axis.span());
        let kinds = [
            file.list.is_some() || file.range.is_some() || file.log_range.is_some(),
            file.zip.is_some(),
            file.sample.is_some(),
            file.repeat.is_some(),
        ];
        if kinds.iter().filter(|kind| **kind).count() != 1 {
            let text = "an axis has one of `list`, `range`, `log-range`, `zip`, `sample` and `repeat`";
            return Err(source.error(span, text));
        }
        let is_parameter = kinds[0];
        if is_parameter != file.path.is_some() {
            let text = match is_parameter {
                true => "`list`, `range` and `log-range` need `path`, the place in the scene",
                false => "`zip`, `sample` and `repeat` name their paths inside; `path` beside them sets nothing",
            };
            return Err(source.error(span, text));
        }
        if let Some(zip) = &file.zip {
            return zipped(zip, span, source);
        }
        if let Some(sample) = &file.sample {
            return sampled(sample, span, source);
        }
        if let Some(repeat) = &file.repeat {
            return repeated(repeat, source);
        }
        let path = file.path.clone().expect("checked above");
        let values = values(&file.list, &file.range, &file.log_range, span, source)?;
        let parameter = parameter(&path, &file.name, &values);
        Ok(Self { parameters: vec![parameter], points: values.values.into_iter().map(|v| vec![v]).collect() })
    }
}

/// The parameter at a path with these values.
fn parameter(path: &Spanned<String>, name: &Option<String>, values: &Listed) -> Parameter {
    Parameter {
        path: Some(path.get_ref().clone()),
        name: name.clone(),
        unit: values.unit.clone(),
        column_type: values.column_type,
    }
}

/// Values of the one of `list`, `range` and `log_range` that is given.
fn values(
    list: &Option<Vec<toml::Value>>,
    range: &Option<RangeFile>,
    log_range: &Option<RangeFile>,
    span: Range<usize>,
    source: &Source,
) -> Result<Listed, SceneError> {
    match (list, range, log_range) {
        (Some(list), None, None) if !list.is_empty() => Ok(listed(list)),
        (Some(_), None, None) => Err(source.error(span, "an empty `list`; allowed is one value or more")),
        (None, Some(range), None) => spaced(range, false, source),
        (None, None, Some(range)) => spaced(range, true, source),
        _ => Err(source.error(span, "allowed is one of `list`, `range` and `log-range`")),
    }
}

/// Evenly spaced values of a range, in the logarithm if `log`; both ends are exact.
fn spaced(range: &RangeFile, log: bool, source: &Source) -> Result<Listed, SceneError> {
    let ends = ends(&range.from, &range.to, log, source)?;
    let count = counted(&range.count, source)?;
    let at = |i: u64| match i {
        0 => ends.from,
        i if i + 1 == count => ends.to,
        i => ends.at(i as f64 / (count - 1) as f64),
    };
    let values = (0..count).map(|i| Measure { number: at(i), unit: ends.unit.clone() }.value()).collect();
    Ok(Listed { values, unit: ends.unit, column_type: ColumnType::Float })
}

/// Both ends of a range, of one unit.
struct Ends {
    from: f64,
    to: f64,
    unit: String,
    log: bool,
}

impl Ends {
    /// The value at a fraction of the range, 0 to 1.
    fn at(&self, share: f64) -> f64 {
        if self.log {
            self.from * libm::exp(share * libm::log(self.to / self.from))
        } else {
            self.from + share * (self.to - self.from)
        }
    }
}

/// Reads both ends of a range.
fn ends(
    from: &Spanned<toml::Value>,
    to: &Spanned<toml::Value>,
    log: bool,
    source: &Source,
) -> Result<Ends, SceneError> {
    let read = |end: &Spanned<toml::Value>| {
        let text = || format!("{} is no number; allowed is a number, or a text such as \"10 kPa\"", end.get_ref());
        Measure::of(end.get_ref()).ok_or_else(|| source.error(end.span(), text()))
    };
    let (first, last) = (read(from)?, read(to)?);
    if first.unit != last.unit {
        let text = format!("`to` is in `{}` and `from` in `{}`; allowed is one unit", last.unit, first.unit);
        return Err(source.error(to.span(), text));
    }
    if log && !(first.number > 0.0 && last.number > 0.0) {
        return Err(source.error(from.span(), "a logarithmic range needs both ends above 0"));
    }
    Ok(Ends { from: first.number, to: last.number, unit: first.unit, log })
}

/// Checks a number of points.
fn counted(count: &Spanned<u64>, source: &Source) -> Result<u64, SceneError> {
    let number = *count.get_ref();
    if (1..=MAX_POINTS).contains(&number) {
        return Ok(number);
    }
    Err(source.error(count.span(), format!("count {number}; allowed is 1 to {MAX_POINTS}")))
}

/// An axis of several parameters that vary together.
fn zipped(zip: &[Spanned<ParameterFile>], span: Range<usize>, source: &Source) -> Result<Axis, SceneError> {
    let mut axis = Axis { parameters: Vec::new(), points: Vec::new() };
    for entry in zip {
        let file = entry.get_ref();
        let values = values(&file.list, &file.range, &file.log_range, entry.span(), source)?;
        axis.parameters.push(parameter(&file.path, &file.name, &values));
        if axis.points.is_empty() {
            axis.points = vec![Vec::new(); values.values.len()];
        }
        if values.values.len() != axis.points.len() {
            let (found, first) = (values.values.len(), axis.points.len());
            let text = format!("{found} values, where the first parameter of the zip has {first}; allowed is as many");
            return Err(source.error(entry.span(), text));
        }
        axis.points.iter_mut().zip(values.values).for_each(|(point, value)| point.push(value));
    }
    if axis.points.is_empty() {
        return Err(source.error(span, "an empty `zip`; allowed is one parameter or more"));
    }
    Ok(axis)
}

/// An axis of random samples. The samples of a parameter do not depend on later parameters.
fn sampled(sample: &SampleFile, span: Range<usize>, source: &Source) -> Result<Axis, SceneError> {
    let count = counted(&sample.count, source)?;
    if sample.over.is_empty() {
        return Err(source.error(span, "`over` is empty; allowed is one parameter or more"));
    }
    let mut axis = Axis { parameters: Vec::new(), points: vec![Vec::new(); count as usize] };
    let mut random = Random::new(sample.seed);
    for entry in &sample.over {
        let file: &SampledFile = entry.get_ref();
        let ends = ends(&file.from, &file.to, file.log, source)?;
        let strata = match sample.method {
            Method::Random => None,
            Method::LatinHypercube => Some(random.permutation(count as usize)),
        };
        for (i, point) in axis.points.iter_mut().enumerate() {
            let share = match &strata {
                None => random.unit(),
                Some(strata) => (strata[i] as f64 + random.unit()) / count as f64,
            };
            point.push(Measure { number: drawn(&ends, file.integer, share), unit: ends.unit.clone() }.value());
        }
        let (path, name) = (Some(file.path.get_ref().clone()), file.name.clone());
        let column_type = if file.integer { ColumnType::Integer } else { ColumnType::Float };
        axis.parameters.push(Parameter { path, name, unit: ends.unit.clone(), column_type });
    }
    Ok(axis)
}

/// The value at a fraction of a range, 0 to 1; whole numbers have fractions of equal length.
fn drawn(ends: &Ends, integer: bool, share: f64) -> f64 {
    if !integer {
        return ends.at(share);
    }
    let (low, high) = (ends.from.min(ends.to).ceil(), ends.from.max(ends.to).floor());
    if ends.log { ends.at(share).round().clamp(low, high) } else { low + (share * (high - low + 1.0)).floor() }
}

/// An axis of repetitions, each with a seed.
fn repeated(repeat: &RepeatFile, source: &Source) -> Result<Axis, SceneError> {
    let count = counted(&repeat.count, source)?;
    let seeds = repeat.path.is_some();
    let seed = |i: u64| repeat.seed.wrapping_add(i);
    let value = |i: u64| {
        let cell = Cell::from(if seeds { seed(i) } else { i });
        ParameterValue { setting: seed(i).to_string(), cell }
    };
    let parameter = Parameter {
        path: repeat.path.as_ref().map(|path| path.get_ref().clone()),
        name: if seeds { None } else { Some("repeat".into()) },
        unit: String::new(),
        column_type: ColumnType::Integer,
    };
    Ok(Axis { parameters: vec![parameter], points: (0..count).map(|i| vec![value(i)]).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The axis of a TOML table.
    fn axis(text: &str) -> Result<Axis, String> {
        #[derive(serde::Deserialize)]
        struct File {
            axis: Vec<Spanned<AxisFile>>,
        }
        let text = format!("[[axis]]\n{text}\n");
        let source = Source::new("sweep.toml", text.clone());
        let file: File = toml::from_str(&text).map_err(|e| e.to_string())?;
        Axis::from_file(&file.axis[0], &source).map_err(|e| e.to_string())
    }

    fn cells(axis: &Axis, parameter: usize) -> Vec<f64> {
        axis.points.iter().map(|point| point[parameter].cell.as_f64().unwrap()).collect()
    }

    #[test]
    fn ranges_have_both_ends_and_even_steps() {
        let even = axis("path = 'a.b'\nrange = { from = '5 kPa', to = '25 kPa', count = 5 }").unwrap();
        assert_eq!(cells(&even, 0), [5.0, 10.0, 15.0, 20.0, 25.0]);
        assert_eq!(even.points[1][0].setting, "\"10 kPa\"");
        let decades = axis("path = 'a.b'\nlog-range = { from = 1e-3, to = 10, count = 5 }").unwrap();
        for (found, exact) in cells(&decades, 0).iter().zip([1e-3, 1e-2, 0.1, 1.0, 10.0]) {
            assert!((found / exact - 1.0).abs() < 1e-14, "{found}");
        }
    }

    #[test]
    fn a_latin_hypercube_has_one_sample_in_each_interval_of_each_parameter() {
        let over = "over = [{ path = 'x', from = 0, to = 1 }, { path = 'y', from = 0, to = 1 }]";
        let of = |method, seed| axis(&format!("sample = {{ method = '{method}', count = 50, seed = {seed}, {over} }}"));
        let cube = of("latin-hypercube", 3).unwrap();
        for parameter in 0..2 {
            let mut strata: Vec<usize> = cells(&cube, parameter).iter().map(|x| (x * 50.0) as usize).collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..50).collect::<Vec<_>>());
        }
        assert_eq!(cells(&cube, 0), cells(&of("latin-hypercube", 3).unwrap(), 0), "the same seed");
        assert_ne!(cells(&cube, 0), cells(&of("latin-hypercube", 4).unwrap(), 0), "another seed");
        let random = cells(&of("random", 3).unwrap(), 1);
        assert!(random.iter().all(|x| (0.0..1.0).contains(x)));
        // Mean of 50 uniform numbers: 1/2, standard deviation 1/sqrt(600); five of them are missed once in 10^6.
        assert!((random.iter().sum::<f64>() / 50.0 - 0.5).abs() < 5.0 / 600.0_f64.sqrt());
    }

    #[test]
    fn integers_are_drawn_with_both_ends() {
        let text = "sample = { method = 'random', count = 400, seed = 1, over = [{ path = 'n', from = 2, to = 5, integer = true }] }";
        let mut counts = [0; 4];
        for value in cells(&axis(text).unwrap(), 0) {
            assert_eq!(value.fract(), 0.0);
            counts[value as usize - 2] += 1;
        }
        // Of a binomial distribution with mean 100 and standard deviation 8.7.
        assert!(counts.iter().all(|n| (56..=144).contains(n)), "{counts:?}");
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, part) in [
            ("path = 'a'", "an axis has one of"),
            ("list = [1]", "need `path`"),
            ("path = 'a'\nlist = []", "an empty `list`"),
            ("path = 'a'\nrange = { from = 1, to = '2 m', count = 3 }", "one unit"),
            ("path = 'a'\nlog-range = { from = 0, to = 2, count = 3 }", "above 0"),
            ("path = 'a'\nrange = { from = 0, to = 2, count = 0 }", "count 0"),
            ("path = 'a'\nrange = { from = 'soft', to = 2, count = 2 }", "no number"),
            ("zip = [{ path = 'a', list = [1, 2] }, { path = 'b', list = [1] }]", "allowed is as many"),
            ("repeat = { count = 2 }\nlist = [1]", "an axis has one of"),
        ] {
            let error = axis(text).unwrap_err();
            assert!(error.contains(part) && error.contains("sweep.toml:"), "{text}: {error}");
        }
    }
}
