//! Reports on a scene engine, measured on scenes: error against run time, stability, and cost. What `pliant report` computes.
//!
//! A case is a scene with quantities to measure and their expected values; a catalogue lists cases, methods and resolutions as a TOML
//! text. [`accuracy`], [`stability`] and [`performance`] run a catalogue and give [`Measurements`]; [`self_convergence`] compares any
//! scene with its own refined solution. [`ReportBuilder`] makes a [`Document`] of them, with a verdict; [`write_report`] writes it as
//! HTML, JSON, CSV and SVG, [`compare`] finds what got worse since an older one. Every run goes through a [`Journal`], so a report
//! that was stopped goes on where it was.
//!
//! This crate names no plugin and has no scene of its own: catalogues and scenes are handed in as texts. It prints nothing; progress
//! goes to a callback.
//!
//! # Example
//! One case of a bar that hangs from its top, from the text of its catalogue to the files of the report:
//! ```no_run
//! use pliant_host::SearchPath;
//! use pliant_engine::session::CancelToken;
//! use pliant_report::*;
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let catalogue = AccuracyCatalogue::parse(&std::fs::read_to_string("cases/catalogue.toml")?)?;
//! let bar = std::fs::read_to_string("cases/bar.toml")?;
//! let scenes = |name: &str| (name == "bar").then_some(bar.as_str());
//!
//! let options = ReportOptions {
//!     search: SearchPath::new(&[]),
//!     threads: 1,
//!     quick: true,
//!     cases: Vec::new(),
//!     seed: 1,
//!     clock: Clock::default(),
//! };
//! let mut progress = |p: Progress<'_>| println!("{} of {}: {}", p.done, p.total, p.what);
//! let mut context = ReportContext::new(options, &mut progress, CancelToken::default());
//! let builder = ReportBuilder::start(&context);
//! let measurements = accuracy(&catalogue, &scenes, &mut context, &mut Journal::none());
//! let document = builder.finish(ReportKind::Accuracy, &context, vec!["report".into()], measurements);
//! let files = write_report(&document, Path::new("out/report"))?;
//! println!("{} met, see {}", document.verdict.passed, files.page.display());
//! # Ok(())
//! # }
//! ```

#![deny(clippy::wildcard_enum_match_arm)]

mod accuracy;
mod baseline;
mod catalogue;
mod clock;
mod context;
mod csv;
mod document;
mod fit;
mod html;
mod journal;
mod markdown;
mod measure;
mod performance;
pub mod plot;
mod row;
mod scene_run;
mod section;
mod self_convergence;
mod settings;
mod stability;
mod write;
mod xml;

pub use accuracy::{AccuracyCatalogue, accuracy};
pub use baseline::{Comparison, Regression, compare};
pub use catalogue::{CatalogueError, NotRun};
pub use clock::{Clock, ClockCheck};
pub use context::{Progress, ReportContext, ReportOptions};
pub use document::{Document, Measurements, ReportBuilder, ReportKind, Verdict};
pub use journal::Journal;
pub use markdown::markdown;
pub use performance::{PerformanceCatalogue, performance};
pub use row::Row;
pub use scene_run::SceneSource;
pub use section::{Section, Table, TableRow};
pub use self_convergence::{SceneInput, self_convergence};
pub use stability::{StabilityCatalogue, stability};
pub use write::{ReportFiles, check_report_folder, write_report};
