//! What a sweep file may say.

use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// A sweep file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct SweepFile {
    /// Version of this format: 1.
    pub(super) format: Spanned<u32>,
    /// A line for people.
    #[serde(default)]
    pub(super) title: String,
    /// Base scenes, relative to the sweep file.
    pub(super) scene: Spanned<OneOrMany>,
    /// Models that take the place of the first body's one after another: files or patterns with `*`, `?` and `**`.
    #[serde(default)]
    pub(super) models: Option<Spanned<OneOrMany>>,
    /// Values that every edit has, by their path in the scene.
    #[serde(default)]
    pub(super) set: BTreeMap<String, toml::Value>,
    /// Axes; edits are their product, the last one varies fastest.
    #[serde(default)]
    pub(super) axis: Vec<Spanned<AxisFile>>,
    /// What is kept of each edit.
    #[serde(default)]
    pub(super) keep: KeepFile,
    /// What an edit may take.
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
    /// All of them.
    pub(super) fn all(&self) -> &[String] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::Many(many) => many,
        }
    }
}

/// One axis: a parameter, several that go in step, samples of several, or repetitions.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct AxisFile {
    pub(super) path: Option<Spanned<String>>,
    pub(super) name: Option<String>,
    pub(super) list: Option<Vec<toml::Value>>,
    pub(super) range: Option<RangeFile>,
    pub(super) log_range: Option<RangeFile>,
    pub(super) zip: Option<Vec<Spanned<ParameterFile>>>,
    pub(super) sample: Option<SampleFile>,
    pub(super) repeat: Option<RepeatFile>,
}

/// A parameter with its values.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct ParameterFile {
    pub(super) path: Spanned<String>,
    pub(super) name: Option<String>,
    pub(super) list: Option<Vec<toml::Value>>,
    pub(super) range: Option<RangeFile>,
    pub(super) log_range: Option<RangeFile>,
}

/// Evenly spaced values, both ends among them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct RangeFile {
    pub(super) from: Spanned<toml::Value>,
    pub(super) to: Spanned<toml::Value>,
    pub(super) count: Spanned<u64>,
}

/// Seeded samples of several parameters.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct SampleFile {
    pub(super) method: Method,
    pub(super) count: Spanned<u64>,
    #[serde(default)]
    pub(super) seed: u64,
    pub(super) over: Vec<Spanned<SampledFile>>,
}

/// How samples are drawn.
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
    pub(super) path: Spanned<String>,
    pub(super) name: Option<String>,
    pub(super) from: Spanned<toml::Value>,
    pub(super) to: Spanned<toml::Value>,
    /// Uniform in the logarithm.
    #[serde(default)]
    pub(super) log: bool,
    /// Whole numbers, both ends among them.
    #[serde(default)]
    pub(super) integer: bool,
}

/// Repetitions of an edit, each with a seed if a path is given.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct RepeatFile {
    pub(super) count: Spanned<u64>,
    /// Path in the scene that takes the seed.
    pub(super) path: Option<Spanned<String>>,
    /// Seed of the first repetition; the others follow one by one.
    #[serde(default)]
    pub(super) seed: u64,
}

/// What is kept of each edit.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub(super) struct KeepFile {
    /// Columns of the summary [default: all].
    pub(super) summary: Option<Spanned<Vec<String>>>,
    /// A column for each probe.
    pub(super) probes: bool,
    /// Columns of the trace, as `trace.csv` names them.
    pub(super) trace: Spanned<Vec<String>>,
    /// Steps from one kept row of the trace to the next.
    pub(super) trace_every: Spanned<u64>,
    /// The deformed meshes.
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

/// What an edit may take.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub(super) struct LimitsFile {
    /// Wall-clock time: a number of seconds, or a text such as `"2 ms"`.
    pub(super) seconds: Option<Spanned<toml::Value>>,
    /// Memory, as `"2 GB"`; edits then run in child processes.
    pub(super) memory: Option<Spanned<String>>,
    /// How often an edit that ran out of time or memory, or whose plugin failed, is tried again.
    pub(super) retries: u32,
}
