//! A look into libraries in child processes: one that crashes, ends or blocks the process which opens it is reported, and the others are listed all the same.
//!
//! A child is this program with the same verb and `--child FILE...`. It opens the files in this order and answers each with a line of JSON. A child that
//! ends before its last answer was ended by the next library, and another child goes on after that one; so there is one child if no library crashes.

use crate::child::{ChildEnd, run_to_end};
use crate::outcome::{Failure, Outcome};
use crate::output::print;
use pliant_host::{FoundLibrary, Library};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// Longest time of a child of a `list` verb.
const LIST_LIMIT: Duration = Duration::from_secs(60);

/// What a child says of a library.
pub struct Surveyed {
    /// A library on the search path, which may be unusable.
    pub found: FoundLibrary,
    /// The answer of the verb, or why there is none.
    pub answer: Result<Value, Failure>,
}

/// Asks children of a `list` verb about libraries, in their order.
///
/// # Errors
/// Fails if no child can be started.
pub fn survey(found: Vec<FoundLibrary>, verb: [&str; 2]) -> Result<Vec<Surveyed>, Failure> {
    let mut answers: Vec<Result<Value, Failure>> = Vec::new();
    while answers.len() < found.len() {
        let left = &found[answers.len()..];
        let (lines, end) = ask_child(left, &verb, LIST_LIMIT)?;
        answers.extend(lines.into_iter().take(left.len()));
        if let Some(unanswered) = found.get(answers.len()) {
            answers.push(Err(no_answer(unanswered, &end)));
        }
    }
    Ok(found.into_iter().zip(answers).map(|(found, answer)| Surveyed { found, answer }).collect())
}

/// The answer of a child of `verb` about one library, which has `limit` for it.
///
/// # Errors
/// The failure that the child tells, or how it ended without an answer.
pub fn ask(found: &FoundLibrary, verb: &[&str], limit: Duration) -> Result<Value, Failure> {
    let (lines, end) = ask_child(std::slice::from_ref(found), verb, limit)?;
    lines.into_iter().next().unwrap_or_else(|| Err(no_answer(found, &end)))
}

/// The failure of a library whose child gave no answer and ended as `end` tells.
fn no_answer(found: &FoundLibrary, end: &str) -> Failure {
    Failure::plugin(format!("{}: cannot be used: while it was opened and asked, {end}", found.path.display()))
}

/// Answers of a child, one for each library in their order, until it ended.
type Answers = Vec<Result<Value, Failure>>;

/// The answers of a child about libraries, and how it ended.
fn ask_child(libraries: &[FoundLibrary], verb: &[&str], limit: Duration) -> Result<(Answers, String), Failure> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(verb).arg("--child").args(libraries.iter().map(|found| &found.path));
    command.stdin(Stdio::null()).stdout(Stdio::piped());
    let end = run_to_end(&mut command, Some(limit));
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
fn parse_answer(line: &str) -> Option<Result<Value, Failure>> {
    let mut line: Value = serde_json::from_str(line).ok()?;
    if let Some(answer) = line.get_mut("answer") {
        return Some(Ok(answer.take()));
    }
    let code = i32::try_from(line["code"].as_i64()?).ok()?;
    Some(Err(Failure { outcome: Outcome::from_exit_code(code)?, text: line["error"].as_str()?.to_owned() }))
}

/// In a child: opens libraries and prints what `look` says of each.
pub fn answer(
    paths: &[PathBuf],
    look: impl Fn(&'static Library, &Path) -> Result<Value, Failure>,
) -> Result<Outcome, Failure> {
    #[cfg(unix)]
    pliant_host::end_with_parent(std::os::unix::process::parent_id());
    for path in paths {
        let line = match Library::open(path).map_err(Failure::from).and_then(|library| look(library, path)) {
            Ok(answer) => json!({ "answer": answer }),
            Err(failure) => json!({ "error": failure.text, "code": failure.outcome.exit_code() }),
        };
        // A library may have begun a line.
        print(&format!("\n{line}"))?;
    }
    Ok(Outcome::Done)
}
