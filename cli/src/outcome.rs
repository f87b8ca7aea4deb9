//! How a command ends.

use pliant_engine::scene::SceneError;
use pliant_engine::session::SessionError;
use pliant_host::HostError;
use pliant_record::RecordingError;
use std::fmt::Display;

/// Exit codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Outcome {
    /// Done.
    Done = 0,
    /// Done, but a check failed.
    CheckFailed = 1,
    /// Unusable input or usage.
    Input = 2,
    /// A plugin or device failed.
    Plugin = 3,
    /// Stopped by the user.
    Stopped = 130,
}

/// What ended a command before it was done.
#[derive(Debug)]
pub struct Failure {
    outcome: Outcome,
    text: String,
}

impl Failure {
    /// Unusable input.
    pub fn input(text: impl Display) -> Self {
        Self { outcome: Outcome::Input, text: text.to_string() }
    }

    /// A plugin or device that failed.
    pub fn plugin(text: impl Display) -> Self {
        Self { outcome: Outcome::Plugin, text: text.to_string() }
    }

    /// Says why, and gives the code.
    pub fn report(self, json: bool) -> Outcome {
        if json {
            let document = serde_json::json!({ "error": self.text, "exit_code": self.outcome as u8 });
            let _ = crate::text::out(&crate::pretty(&document));
        }
        crate::text::note(&format!("error: {}", self.text));
        self.outcome
    }
}

/// Says what is wrong with what was typed, or gives the help that was asked for, and ends the program.
pub fn misused(error: &clap::Error) -> ! {
    if error.use_stderr() && std::env::args_os().any(|argument| argument == "--json") {
        let document = serde_json::json!({ "error": error.render().to_string(), "exit_code": Outcome::Input as u8 });
        let _ = crate::text::out(&crate::pretty(&document));
    }
    error.exit()
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

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        let outcome = if error.is_plugin() { Outcome::Plugin } else { Outcome::Input };
        Self { outcome, text: error.to_string() }
    }
}

impl From<HostError> for Failure {
    fn from(error: HostError) -> Self {
        Self { outcome: Outcome::Plugin, text: error.to_string() }
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::input(error)
    }
}
