//! What a run leaves behind: the deformed model, a row a step, the final nodes, and a summary.
//!
//! Everything is written under a temporary name and renamed when it is whole, so a run that fails or is stopped leaves the
//! results of the one before it as they were.

mod atomic;
mod forces;
mod machine;
mod model;
mod probe;
mod recorder;
mod recording;
mod summary;
mod trace;

pub use atomic::AtomicFile;
pub use machine::Machine;
pub use model::write_model;
pub use probe::ProbeResult;
pub use recorder::Recorder;
pub use recording::{
    Digest, Header, RecordedFile, RecordedStep, Recording, RecordingError, RecordingWriter, state_digest,
};
pub use summary::{BodySummary, CutSummary, StepSeconds, Summary, bodies};
