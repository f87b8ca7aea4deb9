//! Start-up time of the program.

use crate::context::ReportContext;
use crate::fit::{median, relative_range};
use crate::row::Row;
use std::path::Path;
use std::process::{Command, Stdio};

/// Number of times the program is started.
const REPEATS: usize = 9;

/// Measures the time in which the program prints its version.
pub(super) fn start_up(program: &Path, context: &ReportContext<'_>) -> Row {
    let wall = context.options.clock.wall;
    let once = || {
        let began = wall();
        let ended = Command::new(program).arg("--version").stdout(Stdio::null()).status();
        ended.is_ok_and(|status| status.success()).then(|| wall() - began)
    };
    let seconds: Vec<f64> = (0..REPEATS).filter_map(|_| once()).collect();
    Row {
        case: "start-up".into(),
        method: "pliant --version".to_owned(),
        threads: 1,
        wall_seconds: median(&seconds),
        spread: Some(relative_range(&seconds)),
        ..Row::default()
    }
}
