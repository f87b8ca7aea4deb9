//! Runs in child processes, which isolate faulty plugins, excessive memory and calls that do not return.

use super::failure::{Failure, FailureClass};
use super::run_edit::{EditResult, EditSeconds};
use super::serve::Line;
use crate::edit::Resolved;
use crate::error::BatchError;
use crate::sweep::Sweep;
use std::fmt;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The command that starts a child process, which must run [`serve`](super::serve).
#[derive(Clone)]
pub struct Isolation {
    /// Creates the command.
    command: Arc<dyn Fn() -> Command + Send + Sync>,
}

impl Isolation {
    /// Children are started with the result of `command`, whose standard streams are replaced.
    pub fn new(command: impl Fn() -> Command + Send + Sync + 'static) -> Self {
        Self { command: Arc::new(command) }
    }
}

impl fmt::Debug for Isolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Isolation")
    }
}

/// Interval at which a stop of the run is checked.
const TICK: Duration = Duration::from_millis(50);
/// Time between the limit of a run and the kill of its child, which checks the limit itself after each step.
const GRACE: Duration = Duration::from_secs(1);
/// Number of bytes of a child's standard error that are kept, from its end.
const STDERR_KEPT: usize = 4096;

/// Executes runs in a child process, which is started at the first run and used again for the next ones.
pub(super) struct ChildRunner {
    /// How children are started.
    isolation: Isolation,
    /// The child, if there is one.
    running: Option<RunningChild>,
}

/// A child and its pipes.
struct RunningChild {
    /// Process that executes the runs.
    child: Child,
    /// Its standard input.
    input: ChildStdin,
    /// Lines of its standard output.
    lines: Receiver<String>,
    /// Thread that reads its standard error and returns the end of it.
    stderr: JoinHandle<String>,
}

impl ChildRunner {
    /// A runner without a child.
    pub(super) fn new(isolation: Isolation) -> Self {
        Self { isolation, running: None }
    }

    /// Executes a run; `None` if `stop` returned true before its end. `on_open` gets its estimated memory once it is open, bytes.
    ///
    /// # Errors
    /// Fails for a child that cannot be started, cannot write a mesh or reads a changed sweep.
    pub(super) fn run(
        &mut self,
        sweep: &Sweep,
        resolved: &Resolved,
        on_open: &dyn Fn(u64),
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<EditResult>, BatchError> {
        let began = Instant::now();
        let mut child = match self.running.take() {
            Some(child) => child,
            None => self.start()?,
        };
        let failed = |failure: Failure| {
            let seconds = EditSeconds { all: began.elapsed().as_secs_f64(), ..EditSeconds::default() };
            Ok(Some(EditResult::failed(failure, sweep, seconds)))
        };
        // An error means that the child has ended, which is handled below.
        let _ = writeln!(child.input, "{}", resolved.edit.index).and_then(|()| child.input.flush());
        let deadline = sweep.limits.seconds.map(|limit| Duration::from_secs_f64(limit) + GRACE);
        loop {
            match child.lines.recv_timeout(TICK) {
                Ok(line) => {
                    let line = serde_json::from_str(&line)
                        .map_err(|e| BatchError::Input(format!("a child process answered `{line}`: {e}")))?;
                    match line {
                        Line::Opened { memory } => on_open(memory),
                        Line::Ended(reply) => {
                            self.running = Some(child);
                            return reply.result(&resolved.key).map(Some);
                        }
                    }
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return failed(child.end(sweep));
                }
                Err(RecvTimeoutError::Timeout) if stop() => {
                    child.kill();
                    return Ok(None);
                }
                Err(RecvTimeoutError::Timeout) => {
                    if deadline.is_some_and(|deadline| began.elapsed() > deadline) {
                        child.kill();
                        return failed(Failure::time_limit(sweep.limits.seconds.unwrap_or_default()));
                    }
                }
            }
        }
    }

    /// Starts a child.
    fn start(&self) -> Result<RunningChild, BatchError> {
        let mut command = (self.isolation.command)();
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command
            .spawn()
            .map_err(|e| BatchError::Input(format!("a child process for isolated runs cannot be started: {e}")))?;
        let (input, output, error) = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(input), Some(output), Some(error)) = (input, output, error) else {
            return Err(BatchError::Input("a child process for isolated runs has no pipes".into()));
        };
        let (sender, lines) = channel();
        let read_lines = move || {
            let lines = BufReader::new(output).lines().map_while(Result::ok);
            // Sending fails once the receiver has abandoned the child.
            lines.map(|line| sender.send(line)).take_while(Result::is_ok).for_each(drop);
        };
        let threads = || {
            std::thread::Builder::new().spawn(read_lines)?;
            std::thread::Builder::new().spawn(move || read_end(error))
        };
        let stderr = threads().map_err(|e| {
            let _ = child.kill().and_then(|()| child.wait());
            BatchError::Input(format!("a thread that reads from a child process cannot be started: {e}"))
        })?;
        Ok(RunningChild { child, input, lines, stderr })
    }
}

impl Drop for ChildRunner {
    /// Closes the input of the child, at which it ends, and waits for it.
    fn drop(&mut self) {
        if let Some(RunningChild { mut child, input, .. }) = self.running.take() {
            drop(input);
            let _ = child.wait();
        }
    }
}

impl RunningChild {
    /// Kills the child.
    fn kill(mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// The failure of a run during which the child ended.
    fn end(mut self, sweep: &Sweep) -> Failure {
        drop(self.input);
        let status = self.child.wait();
        let stderr = self.stderr.join().unwrap_or_default();
        // Messages of Rust and C++ programs that abort because an allocation fails.
        let messages = ["memory allocation of", "bad_alloc", "Cannot allocate memory"];
        let is_out_of_memory = messages.iter().any(|message| stderr.contains(message));
        if let Some(limit) = sweep.limits.memory.filter(|_| is_out_of_memory) {
            return Failure::new(FailureClass::MemoryLimit, format!("needs more than the {limit} bytes it may"));
        }
        let how = status.map_or_else(|error| error.to_string(), describe_end);
        let last = stderr.lines().rev().find(|line| !line.trim().is_empty()).map(|line| format!(": {line}"));
        Failure::new(FailureClass::Crash, format!("its process ended {how}{}", last.unwrap_or_default()))
    }
}

/// Reads a pipe and returns the last [`STDERR_KEPT`] bytes.
fn read_end(mut pipe: impl Read) -> String {
    let (mut kept, mut buffer) = (Vec::new(), [0; STDERR_KEPT]);
    while let Ok(count @ 1..) = pipe.read(&mut buffer) {
        kept.extend_from_slice(&buffer[..count]);
        kept.drain(..kept.len().saturating_sub(STDERR_KEPT));
    }
    String::from_utf8_lossy(&kept).into_owned()
}

/// Words for how a process ended, after "its process ended".
#[cfg(unix)]
fn describe_end(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt;
    match status.signal() {
        Some(9) => "by signal 9 (kill), as a system does to a process that takes too much memory".into(),
        Some(11) => "by signal 11 (segmentation fault)".into(),
        Some(6) => "by signal 6 (abort)".into(),
        Some(number) => format!("by signal {number}"),
        None => format!("with code {}", status.code().unwrap_or_default()),
    }
}

/// Words for how a process ended, after "its process ended".
#[cfg(not(unix))]
fn describe_end(status: ExitStatus) -> String {
    format!("with {status}")
}
