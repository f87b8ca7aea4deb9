//! Recordings: a session in one file, and back.
//!
//! [`format`] says what is in the file, [`encoding`] how its parts become bytes, [`write`] and [`read`] go over a whole file.

mod digest;
mod encoding;
mod format;
mod read;
mod write;

pub use digest::{Digest, state_digest};
pub use format::{RecordedFile, RecordedStep, RecordingHeader};
pub use read::{Recording, RecordingError, original_of};
pub use write::{RecordingInputs, RecordingWriter};
