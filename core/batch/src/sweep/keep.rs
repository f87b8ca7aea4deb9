//! Results of a run that are kept, and its limits.

use super::file::{KeepFile, LimitsFile};
use crate::execute::SUMMARY;
use pliant_engine::memory::parse_bytes;
use pliant_engine::scene::{SceneError, Source, parse_quantity};

/// Results of a run that are kept.
#[derive(Clone, Debug)]
pub struct Keep {
    /// Names of the columns of the summary, in the order of `SUMMARY` unless the file lists them.
    pub summary: Vec<String>,
    /// Whether each probe has a column.
    pub probes: bool,
    /// Names of the columns of the trace.
    pub trace: Vec<String>,
    /// Number of steps from one kept row of the trace to the next; the last row is always kept.
    pub trace_every: u64,
    /// Whether the deformed meshes are kept.
    pub meshes: bool,
}

impl Keep {
    /// Checks the values of a sweep file.
    ///
    /// # Errors
    /// The first error, with its line.
    pub(super) fn from_file(file: &KeepFile, source: &Source) -> Result<Self, SceneError> {
        let all = || SUMMARY.iter().map(|column| column.name.to_owned()).collect::<Vec<_>>();
        if let Some(summary) = &file.summary {
            for name in summary.get_ref() {
                if !SUMMARY.iter().any(|column| column.name == *name) {
                    let text = format!("no column `{name}` in a summary; allowed is {}", all().join(", "));
                    return Err(source.error(summary.span(), text));
                }
            }
        }
        let trace_every = *file.trace_every.get_ref();
        if trace_every == 0 {
            return Err(source.error(file.trace_every.span(), "0 steps; allowed is 1 or more"));
        }
        Ok(Self {
            summary: file.summary.as_ref().map_or_else(all, |summary| summary.get_ref().clone()),
            probes: file.probes,
            trace: file.trace.get_ref().clone(),
            trace_every,
            meshes: file.meshes,
        })
    }
}

/// Limits of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Largest wall-clock time, s.
    pub seconds: Option<f64>,
    /// Largest memory, bytes. With this limit each run has a child process.
    pub memory: Option<u64>,
    /// Number of retries of a run that exceeded its time or memory, or whose plugin or process failed.
    pub retries: u32,
}

impl Limits {
    /// Checks the values of a sweep file.
    ///
    /// # Errors
    /// The first error, with its line.
    pub(super) fn from_file(file: &LimitsFile, source: &Source) -> Result<Self, SceneError> {
        let seconds = |time: &toml::Spanned<toml::Value>| {
            let number = match time.get_ref() {
                toml::Value::Integer(seconds) => Ok(*seconds as f64),
                toml::Value::Float(seconds) => Ok(*seconds),
                toml::Value::String(text) => parse_quantity(text, "s"),
                toml::Value::Boolean(_) | toml::Value::Datetime(_) | toml::Value::Array(_) | toml::Value::Table(_) => {
                    Err(format!("{}; allowed is a time", time.get_ref()))
                }
            };
            let positive = number.and_then(|s| if s > 0.0 { Ok(s) } else { Err(format!("{s} s; allowed is above 0")) });
            positive.map_err(|reason| source.error(time.span(), reason))
        };
        let bytes = |text: &toml::Spanned<String>| {
            parse_bytes(text.get_ref()).map_err(|reason| source.error(text.span(), reason))
        };
        let seconds = file.seconds.as_ref().map(seconds).transpose()?;
        Ok(Self { seconds, memory: file.memory.as_ref().map(bytes).transpose()?, retries: file.retries })
    }
}
