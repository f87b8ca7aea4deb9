//! Files of a run: the deformed model, a trace with a row for each step, the final nodes, a summary, and recordings of whole sessions that can be
//! replayed.
//!
//! A [`Recorder`] follows a session step by step and writes its results into a folder. A [`RecordingWriter`] writes what a replay needs, and a
//! [`Recording`] reads it. The results of a run get their names together, in one rename, and other files are written atomically
//! ([`AtomicFile`]); so a run that fails or is stopped leaves the results of an earlier one unchanged.
//!
//! This crate computes no physics and prints nothing. It reads a session and never steps it.
//!
//! # Example
//! A session is run, recorded and summarised:
//! ```no_run
//! use pliant_engine::{plan::Plan, scene, session::{Options, Session}};
//! use pliant_record::{Recorder, RecordingInputs, RecordingWriter, RunOutputs};
//! use std::{path::Path, time::Instant};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let began = Instant::now();
//! let (scene, source) = scene::load(Path::new("scenes/touch.toml"), &[])?;
//! let plan = Plan::new(&scene, &source)?;
//! let search = pliant_host::SearchPath::new(&[]);
//! let options = Options::new(search, 1);
//! let mut session = Session::open(&scene, &source, plan, &options)?;
//!
//! let outputs = RunOutputs { folder: Path::new("out/touch"), recording: Some(Path::new("touch.rec")) };
//! let mut recorder = Recorder::new(&scene, &source, &session, outputs, began)?;
//! let inputs = RecordingInputs { scene: &scene, source: &source, session: &session, mesh: None, live: false, history: false };
//! let mut recording = RecordingWriter::create(Path::new("touch.rec"), &inputs)?;
//! for step in 1..=scene.time.steps() {
//!     session.step();
//!     recording.step(&session, session.frame().tools.iter().map(|tool| tool.device_force))?;
//!     recorder.step(&mut session, step == scene.time.steps())?;
//! }
//! recording.finish()?;
//! let summary = recorder.finish(&mut session, false)?;
//! println!("largest force {} N", summary.largest_force);
//! # Ok(())
//! # }
//! ```

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]
#![deny(clippy::wildcard_enum_match_arm)]

mod atomic;
mod content_hash;
mod inputs;
mod machine;
mod model;
mod output;
mod output_paths;
mod plan_report;
mod probe;
mod recorder;
mod recording;
mod result_set;
mod statistics;
mod summary;

pub use atomic::{AtomicFile, remove_leftovers};
pub use content_hash::{ContentHasher, hash_bytes, hash_file};
pub use inputs::InputHash;
pub use machine::Machine;
pub use model::{ModelShape, write_model, write_model_to};
pub use output::{TracedTool, trace_cells, trace_columns, traced_tools};
pub use output_paths::{RunOutputs, check_replaceable};
pub use plan_report::PlanReport;
pub use probe::ProbeResult;
pub use recorder::Recorder;
pub use recording::{
    Digest, RecordedFile, RecordedStep, Recording, RecordingError, RecordingHeader, RecordingInputs, RecordingWriter,
    original_of, state_digest,
};
pub use statistics::RunStatistics;
pub use summary::{BodySummary, CutSummary, Durations, Summary, summarize_bodies};
