//! Failures of runs, by class.

use pliant_engine::session::{EventKind, Session, SessionError};
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::fmt;

/// Class of a failure, for counting and retries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FailureClass {
    /// The scene is invalid.
    Scene,
    /// A model cannot be read or used.
    Model,
    /// An explicit integrator would be unstable.
    StepLimit,
    /// A body was frozen because its material failed or its state was not finite.
    Quarantine,
    /// A plugin cannot be opened, or failed.
    Plugin,
    /// A device was lost.
    DeviceLost,
    /// The run exceeded its time limit.
    TimeLimit,
    /// The run exceeded its memory limit, or is estimated to need more.
    MemoryLimit,
    /// The program or its child process ended in the middle of the run.
    Crash,
}

impl FailureClass {
    /// Whether a retry may succeed. Failures that follow from the scene alone repeat.
    pub fn is_retried(self) -> bool {
        matches!(self, Self::Plugin | Self::DeviceLost | Self::TimeLimit | Self::MemoryLimit | Self::Crash)
    }

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Model => "model",
            Self::StepLimit => "step-limit",
            Self::Quarantine => "quarantine",
            Self::Plugin => "plugin",
            Self::DeviceLost => "device-lost",
            Self::TimeLimit => "time-limit",
            Self::MemoryLimit => "memory-limit",
            Self::Crash => "crash",
        }
    }
}

impl fmt::Display for FailureClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The failure of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// Class of the failure.
    pub class: FailureClass,
    /// What failed, for people.
    pub message: String,
}

impl Failure {
    /// A failure of a class.
    pub(crate) fn new(class: FailureClass, message: impl fmt::Display) -> Self {
        Self { class, message: message.to_string() }
    }

    /// The failure of a run in which the program panicked.
    pub(crate) fn of_panic(panic: &(dyn Any + Send)) -> Self {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        Self::new(FailureClass::Crash, format!("the program panicked: {text}"))
    }

    /// The failure of a run that exceeded its time limit (s).
    pub(super) fn time_limit(limit: f64) -> Self {
        Self::new(FailureClass::TimeLimit, format!("took longer than the {limit} s it may"))
    }

    /// The failure of a run whose session cannot be opened.
    pub(crate) fn of_opening(error: &SessionError) -> Self {
        let class = match error {
            SessionError::StepLimit(_) => FailureClass::StepLimit,
            SessionError::Memory(_) => FailureClass::MemoryLimit,
            SessionError::Obj(_) | SessionError::Tetrahedra(_) | SessionError::Mesh { .. } => FailureClass::Model,
            error if error.is_plugin() => FailureClass::Plugin,
            SessionError::Scene(_)
            | SessionError::Host(_)
            | SessionError::Force(_)
            | SessionError::Lattice { .. }
            | SessionError::VectorUnit(_) => FailureClass::Scene,
        };
        Self::new(class, error)
    }

    /// The failure of a session that was run, if a device was lost or a body was frozen.
    pub(crate) fn of_session(session: &Session) -> Option<Self> {
        let classes =
            [(EventKind::DeviceLost, FailureClass::DeviceLost), (EventKind::Quarantine, FailureClass::Quarantine)];
        classes.into_iter().find_map(|(kind, class)| {
            let (_, event) = session.events.described().iter().find(|(other, _)| *other == kind)?;
            Some(Self::new(class, format!("at {} s: {}", event.time, event.text)))
        })
    }
}
