//! The types that a sweep file is deserialised into.

use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// A sweep file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct SweepFile {
    /// Version of this format: 1.
    pub(super) format: Spanned<u32>,
    /// Title, one line.
    #[serde(default)]
    pub(super) title: String,
    /// Base scenes, relative to the sweep file.
    pub(super) scene: Spanned<OneOrMany>,
    /// Models that replace the first body's in turn: files or patterns with `*`, `?` and `**`.
    #[serde(default)]
    pub(super) models: Option<Spanned<OneOrMany>>,
    /// Settings of every run, by their path in the scene.
    #[serde(default)]
    pub(super) set: BTreeMap<String, toml::Value>,
    /// Axes; runs are their product, the last one varies fastest.
    #[serde(default)]
    pub(super) axis: Vec<Spanned<AxisFile>>,
    /// Results of a run that are kept.
    #[serde(default)]
    pub(super) keep: KeepFile,
    /// Limits of a run.
    #[serde(default)]
    pub(super) limits: LimitsFile,
}

/// One text or a list of them.
#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum OneOrMany {
    One(String),
    Many(Vec<String>),
}

impl OneOrMany {
    /// The texts as a list, of length 1 for a single text.
    pub(super) fn all(&self) -> &[String] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::Many(many) => many,
        }
    }
}

/// An axis: a parameter, several that vary together, random samples of several, or repetitions.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct AxisFile {
    /// Path of the parameter in the scene, for `list`, `range` and `log-range`.
    pub(super) path: Option<Spanned<String>>,
    /// Name of its column [default: the end of the path].
    pub(super) name: Option<String>,
    /// Values of the parameter, as a scene takes them.
    pub(super) list: Option<Vec<toml::Value>>,
    /// Evenly spaced values.
    pub(super) range: Option<RangeFile>,
    /// Values that are evenly spaced in the logarithm.
    pub(super) log_range: Option<RangeFile>,
    /// Several parameters that vary together.
    pub(super) zip: Option<Vec<Spanned<ParameterFile>>>,
    /// Random samples of several parameters.
    pub(super) sample: Option<SampleFile>,
    /// Number of repetitions of each run, and the path of their seed.
    pub(super) repeat: Option<RepeatFile>,
}

/// A parameter with its values.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct ParameterFile {
    /// Path in the scene.
    pub(super) path: Spanned<String>,
    /// Name of its column [default: the end of the path].
    pub(super) name: Option<String>,
    /// Values of the parameter, as a scene takes them.
    pub(super) list: Option<Vec<toml::Value>>,
    /// Evenly spaced values.
    pub(super) range: Option<RangeFile>,
    /// Values that are evenly spaced in the logarithm.
    pub(super) log_range: Option<RangeFile>,
}

/// Evenly spaced values, including both ends.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct RangeFile {
    /// First value: a number, or a text with a unit.
    pub(super) from: Spanned<toml::Value>,
    /// Last value, in the same unit.
    pub(super) to: Spanned<toml::Value>,
    /// Number of values.
    pub(super) count: Spanned<u64>,
}

/// Random samples of several parameters.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct SampleFile {
    /// Method that distributes the samples over the ranges of the parameters.
    pub(super) method: Method,
    /// Number of samples.
    pub(super) count: Spanned<u64>,
    /// Seed of the random numbers.
    #[serde(default)]
    pub(super) seed: u64,
    /// Parameters that are sampled together.
    pub(super) over: Vec<Spanned<SampledFile>>,
}

/// Method that distributes samples over the ranges of parameters.
#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Method {
    /// Independent and uniform.
    Random,
    /// One sample in each of `count` equal intervals of every parameter (McKay, Beckman and Conover 1979).
    LatinHypercube,
}

/// A sampled parameter.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct SampledFile {
    /// Path in the scene.
    pub(super) path: Spanned<String>,
    /// Name of its column [default: the end of the path].
    pub(super) name: Option<String>,
    /// Least value: a number, or a text with a unit.
    pub(super) from: Spanned<toml::Value>,
    /// Greatest value, in the same unit.
    pub(super) to: Spanned<toml::Value>,
    /// Whether samples are uniform in the logarithm.
    #[serde(default)]
    pub(super) log: bool,
    /// Whether samples are whole numbers, including both ends.
    #[serde(default)]
    pub(super) integer: bool,
}

/// Repetitions of a run, each with a seed if a path is given.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct RepeatFile {
    /// Number of repetitions.
    pub(super) count: Spanned<u64>,
    /// Path in the scene that is set to the seed.
    pub(super) path: Option<Spanned<String>>,
    /// Seed of the first repetition; those of the others are consecutive.
    #[serde(default)]
    pub(super) seed: u64,
}

/// Results of a run that are kept.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub(super) struct KeepFile {
    /// Columns of the summary [default: all].
    pub(super) summary: Option<Spanned<Vec<String>>>,
    /// Whether each probe has a column.
    pub(super) probes: bool,
    /// Columns of the trace, named as in `trace.csv`.
    pub(super) trace: Spanned<Vec<String>>,
    /// Number of steps from one kept row of the trace to the next.
    pub(super) trace_every: Spanned<u64>,
    /// Whether the deformed meshes are kept.
    pub(super) meshes: bool,
}

impl Default for KeepFile {
    fn default() -> Self {
        Self {
            summary: None,
            probes: true,
            trace: Spanned::new(0..0, Vec::new()),
            trace_every: Spanned::new(0..0, 1),
            meshes: false,
        }
    }
}

/// Limits of a run.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub(super) struct LimitsFile {
    /// Wall-clock time: a number of seconds, or a text such as `"2 ms"`.
    pub(super) seconds: Option<Spanned<toml::Value>>,
    /// Memory, as `"2 GB"`; each run then has a child process.
    pub(super) memory: Option<Spanned<String>>,
    /// Number of retries of a run that exceeded its time or memory, or whose plugin failed.
    pub(super) retries: u32,
}
