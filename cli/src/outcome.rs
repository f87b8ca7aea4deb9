//! How a command ends.

use pliant_batch::BatchError;
use pliant_engine::scene::SceneError;
use pliant_engine::session::SessionError;
use pliant_host::HostError;
use pliant_record::RecordingError;
use std::fmt::Display;
use std::process::ExitCode;

/// How a command ended, with its exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Outcome {
    /// The command succeeded.
    Done = 0,
    /// The command ran to its end, and a check of its results failed.
    CheckFailed = 1,
    /// A file, value or argument cannot be used.
    Input = 2,
    /// A plugin or device failed.
    Plugin = 3,
    /// The user stopped the command (SIGINT).
    Stopped = 130,
}

impl Outcome {
    /// The exit code.
    pub fn exit_code(self) -> u8 {
        self as u8
    }

    /// The outcome with this exit code, if there is one.
    pub fn from_exit_code(code: i32) -> Option<Self> {
        let all = [Self::Done, Self::CheckFailed, Self::Input, Self::Plugin, Self::Stopped];
        all.into_iter().find(|outcome| i32::from(outcome.exit_code()) == code)
    }
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        Self::from(outcome.exit_code())
    }
}

/// Why a command ended before it was done.
#[derive(Debug)]
pub struct Failure {
    /// The outcome that the exit code tells.
    pub outcome: Outcome,
    /// A sentence on what is wrong, where, and what is allowed.
    pub text: String,
}

impl Failure {
    /// The failure of unusable input, with the sentence that tells what is wrong and what is allowed.
    pub fn input(text: impl Display) -> Self {
        Self { outcome: Outcome::Input, text: text.to_string() }
    }

    /// A plugin or device that failed.
    pub fn plugin(text: impl Display) -> Self {
        Self { outcome: Outcome::Plugin, text: text.to_string() }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::input(error)
    }
}

impl From<RecordingError> for Failure {
    fn from(error: RecordingError) -> Self {
        Self::input(error)
    }
}

impl From<BatchError> for Failure {
    fn from(error: BatchError) -> Self {
        Self::input(error)
    }
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        if error.is_plugin() { Self::plugin(error) } else { Self::input(error) }
    }
}

impl From<HostError> for Failure {
    fn from(error: HostError) -> Self {
        Self::plugin(error)
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::input(error)
    }
}
