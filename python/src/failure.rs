//! Everything that goes wrong becomes one Python exception, `pliant.PliantError`, with what kind of thing went wrong and where.

use pliant_engine::scene::SceneError;
use pliant_engine::session::{SessionError, SnapshotError};
use pliant_host::HostError;
use pliant_mesh::ObjError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

/// What went wrong; Python sees it as the `kind` of the exception.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The scene says something it cannot.
    Scene,
    /// A model cannot be read or used.
    Model,
    /// A plugin or device failed.
    Plugin,
    /// A file cannot be read or written.
    File,
    /// An argument makes no sense.
    Argument,
    /// A view of positions is older than the last step.
    Stale,
    /// Another thread is using the session.
    Busy,
    /// The session was closed, or belongs to another process.
    Closed,
    /// A fault of the program itself.
    Panic,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Model => "model",
            Self::Plugin => "plugin",
            Self::File => "file",
            Self::Argument => "argument",
            Self::Stale => "stale",
            Self::Busy => "busy",
            Self::Closed => "closed",
            Self::Panic => "panic",
        }
    }
}

/// Why a call did not do what it should.
#[derive(Debug)]
pub struct Failure {
    kind: Kind,
    text: String,
    /// File with line and column, or what else tells the place.
    place: Option<String>,
}

impl Failure {
    /// Something wrong at no place in particular.
    pub fn new(kind: Kind, text: impl ToString) -> Self {
        Self { kind, text: text.to_string(), place: None }
    }

    /// An argument that makes no sense.
    pub fn argument(text: impl ToString) -> Self {
        Self::new(Kind::Argument, text)
    }

    /// Whether the program itself is at fault.
    pub fn is_panic(&self) -> bool {
        self.kind == Kind::Panic
    }

    /// The same with the place of what is wrong.
    pub fn at(mut self, place: impl ToString) -> Self {
        self.place = Some(place.to_string());
        self
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::new(Kind::Scene, &error).at(error.place())
    }
}

impl From<ObjError> for Failure {
    fn from(error: ObjError) -> Self {
        let place = match &error {
            ObjError::Read { file, .. } => file.display().to_string(),
            ObjError::Line { file, line, .. } => format!("{}:{line}", file.display()),
        };
        Self::new(Kind::Model, error).at(place)
    }
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        let kind = if error.is_plugin() { Kind::Plugin } else { Kind::Scene };
        match error {
            SessionError::Scene(error) | SessionError::Memory(error) => error.into(),
            SessionError::Obj(error) => error.into(),
            SessionError::Mesh { ref file, .. } => {
                let place = file.display().to_string();
                Self::new(Kind::Model, error).at(place)
            }
            SessionError::Host(error) => error.into(),
            error => Self::new(kind, error),
        }
    }
}

impl From<HostError> for Failure {
    fn from(error: HostError) -> Self {
        let kind = if error.is_refusal() { Kind::Scene } else { Kind::Plugin };
        Self::new(kind, error)
    }
}

impl From<SnapshotError> for Failure {
    fn from(error: SnapshotError) -> Self {
        Self::new(Kind::Argument, error)
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::new(Kind::File, error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
        Python::attach(|py| {
            let made = CLASS
                .import(py, "pliant._error", "PliantError")
                .and_then(|class| class.call1((failure.text.as_str(), failure.kind.name(), failure.place.as_deref())));
            made.map_or_else(|error| error, Self::from_value)
        })
    }
}

thread_local! {
    /// Whether this thread is inside of a call whose panics are caught here.
    static INSIDE: Cell<bool> = const { Cell::new(false) };
    /// Where the last panic of this thread was.
    static PLACE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Makes panics inside of [`contained`] keep their place instead of printing it; others go to the hook there was before.
pub fn install_panic_hook() {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if INSIDE.get() {
            PLACE.set(info.location().map(ToString::to_string));
        } else {
            before(info);
        }
    }));
}

/// Does `work`; a panic in it becomes a [`Failure`] instead of a message on the console.
pub fn contained<R>(work: impl FnOnce() -> Result<R, Failure>) -> Result<R, Failure> {
    static HOOK: Once = Once::new();
    HOOK.call_once(install_panic_hook);
    let outer = INSIDE.replace(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    INSIDE.set(outer);
    done.unwrap_or_else(|panic| {
        let text = format!("a fault of pliant itself, please report it: {}", panic_text(panic.as_ref()));
        let failure = Failure::new(Kind::Panic, text);
        Err(match PLACE.take() {
            Some(place) => failure.at(place),
            None => failure,
        })
    })
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("it says nothing")
}

/// Panics with a text, so that tests see what becomes of a panic.
#[pyfunction]
pub fn raise_panic(text: String) -> PyResult<()> {
    Ok(contained(|| -> Result<(), Failure> { std::panic::panic_any(text) })?)
}
