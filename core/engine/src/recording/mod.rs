//! Recordings of sessions: the file format, reading, and hands that a scene takes from a file.
//!
//! [`mod@format`] defines the file format, `read` reads it, and `hands` lets the steps of a session take their hands and commands from it.
//! `pliant_record` writes recordings.

pub mod format;

mod decoding;
mod digest;
mod hands;
mod read;
mod recorded_path;

pub use digest::{Digest, state_digest};
pub use format::{RecordedFile, RecordedStep, RecordingHeader};
pub use hands::RecordedHands;
pub use read::{Recording, RecordingError, original_of};
