//! Child processes and how they end.

use std::fmt;
use std::io::Read;
use std::process::{Child, Command, ExitStatus};
use std::thread;
use std::time::{Duration, Instant};

/// How a child process ended.
pub enum ChildEnd {
    /// It exited by itself.
    Exited {
        /// Exit code that the process returned.
        code: i32,
        /// Standard output, if it was piped.
        stdout: String,
        /// Standard error, if it was piped.
        stderr: String,
    },
    /// It was ended by a signal.
    Signalled {
        /// The signal, in words.
        signal: String,
        /// Standard output until then, if it was piped.
        stdout: String,
    },
    /// It did not end in time, and was killed.
    TimedOut {
        /// Longest time that it had.
        limit: Duration,
        /// Standard output until then, if it was piped.
        stdout: String,
    },
    /// It could not be started or waited for.
    NotStarted(std::io::Error),
}

impl fmt::Display for ChildEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exited { code, .. } => write!(f, "the process ended with code {code}"),
            Self::Signalled { signal, .. } => write!(f, "the process was ended by {signal}"),
            Self::TimedOut { limit, .. } => write!(f, "the process did not end within {} s", limit.as_secs_f64()),
            Self::NotStarted(error) => write!(f, "the process could not be started: {error}"),
        }
    }
}

/// Runs a child to its end, or kills it after `limit`.
pub fn run_to_end(command: &mut Command, limit: Option<Duration>) -> ChildEnd {
    let mut child = match command.spawn() {
        Ok(child) => child,
        Err(error) => return ChildEnd::NotStarted(error),
    };
    // Read while waiting: a child that writes more than a pipe holds blocks until its pipe is read.
    let pipes = (|| Ok((read_all(child.stdout.take())?, read_all(child.stderr.take())?)))();
    let (stdout, stderr) = match pipes {
        Ok(readers) => readers,
        Err(error) => {
            let _ = child.kill().and_then(|()| child.wait());
            return ChildEnd::NotStarted(error);
        }
    };
    match wait(&mut child, limit) {
        Ok(Some(status)) => match status.code() {
            Some(code) => ChildEnd::Exited { code, stdout: text_of(stdout), stderr: text_of(stderr) },
            None => ChildEnd::Signalled { signal: signal_name(status), stdout: text_of(stdout) },
        },
        Ok(None) => ChildEnd::TimedOut { limit: limit.unwrap_or_default(), stdout: text_of(stdout) },
        Err(error) => ChildEnd::NotStarted(error),
    }
}

/// Waits for a child; `None` if it was killed after `limit`.
fn wait(child: &mut Child, limit: Option<Duration>) -> std::io::Result<Option<ExitStatus>> {
    let Some(limit) = limit else { return child.wait().map(Some) };
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if start.elapsed() > limit {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(Duration::from_millis(2));
    }
}

/// A thread that reads a pipe, if there is one.
type PipeReader = Option<thread::JoinHandle<String>>;

/// Reads a pipe to its end on a thread.
///
/// # Errors
/// The error of the system if it gives no thread.
fn read_all(pipe: Option<impl Read + Send + 'static>) -> std::io::Result<PipeReader> {
    let read = |mut pipe: _| {
        move || {
            let mut bytes = Vec::new();
            let _ = Read::read_to_end(&mut pipe, &mut bytes);
            String::from_utf8_lossy(&bytes).into_owned()
        }
    };
    pipe.map(|pipe| thread::Builder::new().spawn(read(pipe))).transpose()
}

/// What was read; empty without a pipe.
fn text_of(reader: PipeReader) -> String {
    reader.and_then(|r| r.join().ok()).unwrap_or_default()
}

/// The signal that ended a process, by number and name.
#[cfg(unix)]
pub fn signal_name(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt;
    let number = status.signal().unwrap_or(0);
    let name = match number {
        4 => " (illegal instruction)",
        6 => " (abort)",
        8 => " (arithmetic fault)",
        9 => " (kill)",
        7 | 10 => " (bus error)",
        11 => " (segmentation fault)",
        15 => " (terminate)",
        _ => "",
    };
    format!("signal {number}{name}")
}

/// How a process ended, in the words of the system.
#[cfg(not(unix))]
pub fn signal_name(status: ExitStatus) -> String {
    status.to_string()
}
