//! The simulation on a thread of its own: opens a model, steps it in real time, and does what the window asks between two steps.

mod autosave;
mod device_strokes;
mod early;
mod export;
mod faint_stroke;
mod gauges;
mod history;
mod launch;
mod messages;
mod session_file;
mod shape_copy;
mod takeover;
mod thread;

pub use autosave::{Abandoned, abandoned, state_folder};
pub use early::EarlySimulation;
pub use export::{ModelFormat, write_bodies};
pub use gauges::{Gauges, StepTimes};
pub use history::{HistoryStep, Stroke, StrokeLog};
pub use launch::prepare;
pub use messages::{Command, EndedRun, Notice, OpenModel, Status};
pub use takeover::Predecessor;

use crate::opening::OpenRequest;
use pliant_engine::session::CancelToken;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use triple_buffer::{Output, triple_buffer};

/// The window's end of a simulation.
pub struct Simulation {
    commands: Sender<Command>,
    notices: Receiver<Notice>,
    status: Output<Status>,
    thread: Option<JoinHandle<()>>,
    /// Ends the step that is under way.
    cancel: CancelToken,
    /// Where it leaves its live session for another simulation.
    handover: takeover::Handover,
}

impl Simulation {
    /// Begins to open what is asked for, and then to step it, with frames for a viewer or without. `wake` is called after each notice. A predecessor gives its device
    /// once the new session is open, and ends.
    ///
    /// # Errors
    /// A system that gives no thread.
    pub fn start(
        request: OpenRequest,
        viewing: bool,
        before: Option<Predecessor>,
        wake: impl Fn() + Send + 'static,
    ) -> std::io::Result<Self> {
        let (commands, to_do) = channel();
        let (sender, notices) = channel();
        let (input, status) = triple_buffer(&Status::default());
        let notifier = messages::Notifier { sender, wake: Box::new(wake) };
        let cancel = CancelToken::default();
        let token = cancel.clone();
        let handover = takeover::Handover::default();
        let left = std::sync::Arc::clone(&handover);
        let run = move || {
            let channels = thread::Channels { commands: &to_do, notifier: &notifier, cancel: token, handover: &left };
            thread::run(&request, viewing, before, channels, input)
        };
        let thread = launch::spawn(Box::new(run))?;
        Ok(Self { commands, notices, status, thread: Some(thread), cancel, handover })
    }

    /// Asks for something; it is done between two steps.
    pub fn send(&self, command: Command) {
        // A simulation that has ended has said why.
        let _ = self.commands.send(command);
    }

    /// What has happened since the last call.
    pub fn notices(&self) -> Vec<Notice> {
        self.notices.try_iter().collect()
    }

    /// The newest state of affairs.
    pub fn status(&mut self) -> &Status {
        self.status.read()
    }

    /// Ends the simulation and waits for its last notices.
    pub fn finish(mut self) -> Vec<Notice> {
        self.end();
        self.notices()
    }

    fn end(&mut self) {
        self.send(Command::End);
        self.cancel.cancel();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Drop for Simulation {
    fn drop(&mut self) {
        self.end();
    }
}
