//! Recordings of sessions, for replay.
//!
//! [`format`] defines the file format, [`encoding`] the bytes of its parts; [`write`] and [`read`] write and read files.

mod digest;
mod encoding;
mod format;
mod read;
mod write;

pub use digest::{Digest, state_digest};
pub use format::{RecordedFile, RecordedStep, RecordingHeader};
pub use read::{Recording, RecordingError, original_of};
pub use write::{RecordingInputs, RecordingWriter};
