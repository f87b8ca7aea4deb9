//! Writing of recordings; `pliant_engine::recording` has the file format and reads them.

mod encoding;
mod write;

pub use pliant_engine::recording::{
    Digest, RecordedFile, RecordedStep, Recording, RecordingError, RecordingHeader, original_of, state_digest,
};
pub use write::{RecordingInputs, RecordingWriter};
