//! The only place that prints, and numbers as people read them. What is printed has its control characters escaped.
#![allow(clippy::print_stderr, reason = "this is where it is done")]

use crate::escape::escape_controls;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use pliant_engine::session::Warning;
use std::io::{self, ErrorKind, Write};

/// Prints a result on standard output, ending with a line break. A reader that has gone away is no error.
///
/// # Errors
/// A standard output that cannot be written.
pub fn print(text: &str) -> io::Result<()> {
    let text = escape_controls(text);
    let mut stdout = io::stdout().lock();
    let written = stdout
        .write_all(text.as_bytes())
        .and_then(|()| if text.ends_with('\n') { Ok(()) } else { stdout.write_all(b"\n") });
    match written.and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(io::Error::new(error.kind(), format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a result as JSON on standard output.
///
/// # Errors
/// A standard output that cannot be written.
pub fn print_json(value: &impl serde::Serialize) -> io::Result<()> {
    print(&serde_json::to_string_pretty(value).map_err(io::Error::other)?)
}

/// Prints a line for people on standard error.
pub fn note(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", escape_controls(text));
}

/// Prints warnings for people on standard error, a line each.
pub fn note_warnings(warnings: &[Warning]) {
    warnings.iter().for_each(|warning| note(&format!("warning {warning}")));
}

/// A progress bar over `length` items on standard error, hidden if `quiet`. The template is one of indicatif.
pub fn progress_bar(template: &str, length: u64, quiet: bool) -> ProgressBar {
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(length).with_style(style);
    bar.set_draw_target(if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) });
    bar
}

/// Puts a message into a progress bar.
pub fn set_message(bar: &ProgressBar, text: &str) {
    bar.set_message(escape_controls(text).into_owned());
}

/// A time (s) as people read it.
pub fn format_seconds(s: f64) -> String {
    match s {
        s if s >= 1.0 => format!("{s:.2} s"),
        s if s >= 1e-3 => format!("{:.3} ms", s * 1e3),
        s => format!("{:.1} us", s * 1e6),
    }
}

/// `1 step`, `2 steps`.
pub fn count(number: u64, noun: &str) -> String {
    if number == 1 { format!("1 {noun}") } else { format!("{number} {noun}s") }
}
