//! `pliant doctor`: what the window finds here. The window's program is asked, so that this one needs no graphics library.

use crate::args::Cli;
use crate::child::{ChildEnd, run_to_end};
use crate::edit::find_window;
use crate::outcome::{Failure, Outcome};
use crate::output::{print, print_json};
use serde_json::json;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Longest time for an answer of the window's program: a software renderer that compiles its first programs takes a second.
const PATIENCE: Duration = Duration::from_secs(20);

/// Says which renderer the window would get, or why there is none.
pub fn doctor(cli: &Cli) -> Result<Outcome, Failure> {
    let found = window_renderer();
    let outcome = if found.is_ok() { Outcome::Done } else { Outcome::CheckFailed };
    if cli.json {
        print_json(&match &found {
            Ok(renderer) => json!({ "window": { "renderer": renderer } }),
            Err(why) => json!({ "window": { "missing": why } }),
        })?;
        return Ok(outcome);
    }
    let window = match found {
        Ok(renderer) => format!("  good     window: it draws with {renderer}"),
        Err(why) => format!("  missing  window: {why}"),
    };
    print(&format!("this machine\n{window}\n`pliant device doctor` says what devices need"))?;
    Ok(outcome)
}

/// The renderer as its driver calls it.
///
/// # Errors
/// A sentence on why a window cannot be opened.
fn window_renderer() -> Result<String, String> {
    let program = find_window().map_err(|failure| failure.text)?;
    let mut command = Command::new(&program);
    command.arg("--renderer").stdout(Stdio::piped()).stderr(Stdio::piped());
    let sentence = |text: &str| text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default().trim().to_owned();
    match run_to_end(&mut command, Some(PATIENCE)) {
        ChildEnd::Exited { code: 0, stdout, .. } => Ok(sentence(&stdout)),
        ChildEnd::Exited { code, stderr, .. } => {
            let said = sentence(&stderr);
            let said = said.strip_prefix("error: ").unwrap_or(&said);
            Err(if said.is_empty() { format!("{} ended with code {code}", program.display()) } else { said.into() })
        }
        end @ (ChildEnd::Signalled { .. } | ChildEnd::TimedOut { .. } | ChildEnd::NotStarted(_)) => {
            Err(format!("{}: {end}", program.display()))
        }
    }
}
