//! The only place that prints.
#![allow(clippy::print_stderr, reason = "this is where it is done")]

use crate::outcome::{Failure, Outcome};
use std::io::{ErrorKind, Write};

/// A result, on standard output. A reader that has gone away is no error.
pub fn out(text: &str) -> Result<Outcome, Failure> {
    let mut stdout = std::io::stdout().lock();
    let written = stdout
        .write_all(text.as_bytes())
        .and_then(|()| if text.ends_with('\n') { Ok(()) } else { stdout.write_all(b"\n") });
    match written.and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::input(format!("standard output: {error}"))),
        _ => Ok(Outcome::Done),
    }
}

/// A line for people, on standard error.
pub fn note(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// Seconds as a person reads them.
pub fn seconds(s: f64) -> String {
    match s {
        s if s >= 1.0 => format!("{s:.2} s"),
        s if s >= 1e-3 => format!("{:.3} ms", s * 1e3),
        s => format!("{:.1} us", s * 1e6),
    }
}

/// Bytes as a person reads them.
pub fn bytes(b: u64) -> String {
    match b as f64 {
        b if b >= 1e9 => format!("{:.2} GB", b / 1e9),
        b if b >= 1e6 => format!("{:.1} MB", b / 1e6),
        b => format!("{:.0} kB", b / 1e3),
    }
}
