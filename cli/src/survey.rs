//! A look into libraries in child processes: one that crashes the process which opens it is reported, and the others are listed all the same.
//!
//! A child is this program with a `list` verb and `--child FILE...`. It opens the files in this order and answers each with a line of JSON. A child that
//! ends before its last answer was ended by the next library, and another child goes on after that one; so there is one child if no library crashes.

use crate::child::{ChildEnd, run_to_end};
use crate::outcome::{Failure, Outcome};
use crate::output::print;
use pliant_host::{FoundLibrary, Library};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// Longest time of a child.
const LIMIT: Duration = Duration::from_secs(60);

/// What a child says of a library.
pub struct Surveyed {
    /// A library on the search path, which may be unusable.
    pub found: FoundLibrary,
    /// The answer of the verb, or why there is none.
    pub answer: Result<Value, String>,
}

/// Asks children of `verb` about libraries, in their order.
///
/// # Errors
/// Fails if no child can be started.
pub fn survey(found: Vec<FoundLibrary>, verb: [&str; 2]) -> Result<Vec<Surveyed>, Failure> {
    let mut answers: Vec<Result<Value, String>> = Vec::new();
    while answers.len() < found.len() {
        let left = &found[answers.len()..];
        let (lines, end) = ask_child(left, verb)?;
        answers.extend(lines.into_iter().take(left.len()));
        if let Some(FoundLibrary { path, .. }) = found.get(answers.len()) {
            answers.push(Err(format!("{}: cannot be read: while it was opened, {end}", path.display())));
        }
    }
    Ok(found.into_iter().zip(answers).map(|(found, answer)| Surveyed { found, answer }).collect())
}

/// The answers of a child about the libraries that it could open, in their order, and how it ended.
fn ask_child(libraries: &[FoundLibrary], verb: [&str; 2]) -> Result<(Vec<Result<Value, String>>, String), Failure> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(verb).arg("--child").args(libraries.iter().map(|found| &found.path));
    command.stdin(Stdio::null()).stdout(Stdio::piped());
    let end = run_to_end(&mut command, Some(LIMIT));
    let text = end.to_string();
    let stdout = match end {
        ChildEnd::Exited { stdout, .. } | ChildEnd::Signalled { stdout, .. } | ChildEnd::TimedOut { stdout, .. } => {
            stdout
        }
        ChildEnd::NotStarted(_) => return Err(Failure::input(format!("to open libraries, {text}"))),
    };
    Ok((stdout.lines().filter_map(parse_answer).collect(), text))
}

/// An answer from its line; `None` for what a library printed itself.
fn parse_answer(line: &str) -> Option<Result<Value, String>> {
    let mut line: Value = serde_json::from_str(line).ok()?;
    match (line.get_mut("answer").map(Value::take), line.get("error")) {
        (Some(answer), _) => Some(Ok(answer)),
        (None, Some(error)) => Some(Err(error.as_str()?.to_owned())),
        (None, None) => None,
    }
}

/// In a child: opens libraries and prints what `look` says of each.
pub fn answer(paths: &[PathBuf], look: impl Fn(&'static Library, &Path) -> Value) -> Result<Outcome, Failure> {
    #[cfg(unix)]
    pliant_host::end_with_parent(std::os::unix::process::parent_id());
    for path in paths {
        let line = match Library::open(path) {
            Ok(library) => json!({ "answer": look(library, path) }),
            Err(error) => json!({ "error": error.to_string() }),
        };
        // A library may have begun a line.
        print(&format!("\n{line}"))?;
    }
    Ok(Outcome::Done)
}
