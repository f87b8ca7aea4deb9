//! Edits in a child process, which a faulty plugin, too much memory or a call that never returns may end.

use super::failure::{Failure, FailureClass};
use super::run_edit::{EditResult, EditSeconds};
use super::serve::Reply;
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

/// How a child process is started: a command that ends in [`serve`](super::serve).
#[derive(Clone)]
pub struct Isolation {
    command: Arc<dyn Fn() -> Command + Send + Sync>,
}

impl Isolation {
    /// Children are started with what `command` gives; its standard streams are replaced.
    pub fn new(command: impl Fn() -> Command + Send + Sync + 'static) -> Self {
        Self { command: Arc::new(command) }
    }
}

impl fmt::Debug for Isolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Isolation")
    }
}

/// Time from one look at whether the run was stopped to the next.
const TICK: Duration = Duration::from_millis(50);
/// Time a child may go on after the limit of an edit: it looks at the limit itself after each step.
const GRACE: Duration = Duration::from_secs(1);
/// Largest number of bytes kept of what a child says on standard error.
const SAID: usize = 4096;

/// Runs edits in a child that is started when it is needed and stays for the next edit.
pub(super) struct ChildRunner {
    isolation: Isolation,
    running: Option<RunningChild>,
}

/// A child and its pipes.
struct RunningChild {
    child: Child,
    input: ChildStdin,
    lines: Receiver<String>,
    said: JoinHandle<String>,
}

impl ChildRunner {
    /// No child is started yet.
    pub(super) fn new(isolation: Isolation) -> Self {
        Self { isolation, running: None }
    }

    /// Runs an edit; `None` if `stop` said so before its end.
    ///
    /// # Errors
    /// A child that cannot be started, that cannot write a mesh, or that reads another sweep.
    pub(super) fn run(
        &mut self,
        sweep: &Sweep,
        resolved: &Resolved,
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
        // One that has ended by now does not read; that it has ended is seen below.
        let _ = writeln!(child.input, "{}", resolved.edit.place).and_then(|()| child.input.flush());
        let patience = sweep.limits.seconds.map(|limit| (limit, Duration::from_secs_f64(limit) + GRACE));
        loop {
            match child.lines.recv_timeout(TICK) {
                Ok(line) => {
                    let reply: Reply = serde_json::from_str(&line)
                        .map_err(|e| BatchError::Input(format!("a child process answered `{line}`: {e}")))?;
                    self.running = Some(child);
                    return reply.result(&resolved.key).map(Some);
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return failed(child.end(sweep));
                }
                Err(RecvTimeoutError::Timeout) if stop() => {
                    child.kill();
                    return Ok(None);
                }
                Err(RecvTimeoutError::Timeout) => {
                    if let Some((limit, _)) = patience.filter(|(_, patience)| began.elapsed() > *patience) {
                        child.kill();
                        return failed(Failure::time_limit(limit));
                    }
                }
            }
        }
    }

    fn start(&self) -> Result<RunningChild, BatchError> {
        let mut command = (self.isolation.command)();
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command
            .spawn()
            .map_err(|e| BatchError::Input(format!("a child process for isolated edits cannot be started: {e}")))?;
        let (input, output, error) = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(input), Some(output), Some(error)) = (input, output, error) else {
            return Err(BatchError::Input("a child process for isolated edits has no pipes".into()));
        };
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            let lines = BufReader::new(output).lines().map_while(Result::ok);
            // The other end hangs up once it has given up the child.
            lines.map(|line| sender.send(line)).take_while(Result::is_ok).for_each(drop);
        });
        let said = std::thread::spawn(move || last_words(error));
        Ok(RunningChild { child, input, lines, said })
    }
}

impl Drop for ChildRunner {
    /// Ends the child: its input ends, so it does too.
    fn drop(&mut self) {
        if let Some(RunningChild { mut child, input, .. }) = self.running.take() {
            drop(input);
            let _ = child.wait();
        }
    }
}

impl RunningChild {
    fn kill(mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// Why a child ended in the middle of an edit.
    fn end(mut self, sweep: &Sweep) -> Failure {
        drop(self.input);
        let status = self.child.wait();
        let said = self.said.join().unwrap_or_default();
        // What Rust and C++ say when an allocation fails, before they abort.
        let starved = ["memory allocation of", "bad_alloc", "Cannot allocate memory"].iter().any(|s| said.contains(s));
        if let Some(limit) = sweep.limits.memory.filter(|_| starved) {
            return Failure::new(FailureClass::MemoryLimit, format!("needs more than the {limit} bytes it may"));
        }
        let how = status.map_or_else(|error| error.to_string(), ended_by);
        let last = said.lines().rev().find(|line| !line.trim().is_empty()).map(|line| format!(": {line}"));
        Failure::new(FailureClass::Crash, format!("its process ended {how}{}", last.unwrap_or_default()))
    }
}

/// The last of what a pipe gives, until its end.
fn last_words(mut pipe: impl Read) -> String {
    let (mut said, mut buffer) = (Vec::new(), [0; SAID]);
    while let Ok(count @ 1..) = pipe.read(&mut buffer) {
        said.extend_from_slice(&buffer[..count]);
        said.drain(..said.len().saturating_sub(SAID));
    }
    String::from_utf8_lossy(&said).into_owned()
}

/// How a process ended.
#[cfg(unix)]
fn ended_by(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt;
    match status.signal() {
        Some(9) => "by signal 9 (kill), as a system does to a process that takes too much memory".into(),
        Some(11) => "by signal 11 (segmentation fault)".into(),
        Some(6) => "by signal 6 (abort)".into(),
        Some(number) => format!("by signal {number}"),
        None => format!("with code {}", status.code().unwrap_or_default()),
    }
}

/// How a process ended.
#[cfg(not(unix))]
fn ended_by(status: ExitStatus) -> String {
    format!("with {status}")
}
