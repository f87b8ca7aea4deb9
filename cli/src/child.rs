//! Child processes, and how they end.

use std::fmt;
use std::io::Read;
use std::process::{Child, Command, ExitStatus};
use std::thread;
use std::time::{Duration, Instant};

/// How a child ended.
pub enum Ended {
    /// By itself: code, standard output and error where they were piped.
    Code(i32, String, String),
    /// By a signal, or whatever the system has.
    Killed(String),
    /// Not within its time; it was ended.
    Late(Duration),
    /// It never began.
    NotStarted(std::io::Error),
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Code(code, ..) => write!(f, "the process ended with code {code}"),
            Self::Killed(how) => write!(f, "the process was ended by {how}"),
            Self::Late(limit) => write!(f, "the process did not end within {} s", limit.as_secs_f64()),
            Self::NotStarted(error) => write!(f, "the process could not be started: {error}"),
        }
    }
}

/// Runs a child to its end, or to a limit of time.
pub fn wait(command: &mut Command, limit: Option<Duration>) -> Ended {
    let mut child = match command.spawn() {
        Ok(child) => child,
        Err(error) => return Ended::NotStarted(error),
    };
    // Read beside the wait: a child that says more than a pipe holds would wait for a reader.
    let (out, err) = (reader(child.stdout.take()), reader(child.stderr.take()));
    match status(&mut child, limit) {
        Ok(Some(status)) => match status.code() {
            Some(code) => Ended::Code(code, text(out), text(err)),
            None => Ended::Killed(signal(status)),
        },
        Ok(None) => Ended::Late(limit.unwrap_or_default()),
        Err(error) => Ended::NotStarted(error),
    }
}

fn status(child: &mut Child, limit: Option<Duration>) -> std::io::Result<Option<ExitStatus>> {
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

type Reading = Option<thread::JoinHandle<String>>;

fn reader(pipe: Option<impl Read + Send + 'static>) -> Reading {
    pipe.map(|mut pipe| {
        thread::spawn(move || {
            let mut bytes = Vec::new();
            let _ = pipe.read_to_end(&mut bytes);
            String::from_utf8_lossy(&bytes).into_owned()
        })
    })
}

fn text(reading: Reading) -> String {
    reading.and_then(|r| r.join().ok()).unwrap_or_default()
}

#[cfg(unix)]
fn signal(status: ExitStatus) -> String {
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

#[cfg(not(unix))]
fn signal(status: ExitStatus) -> String {
    status.to_string()
}
