//! `pliant plugin check`: runs the conformance suite on a library, with a process and a line for each case.
//!
//! This process never opens the library: each case runs in a child, so a plugin that crashes or hangs fails its case and nothing else. A
//! child is this program with `--child list`, which times the opening and lists the plugins, or `--child INDEX/CASE`, which runs a case; it answers with a line
//! of JSON. Before a call that may end it at a page without access, it writes a line of JSON that says what the call did then.

use crate::args::{CheckArgs, Cli};
use crate::child::{ChildEnd, run_to_end};
use crate::outcome::{Failure, Outcome};
use crate::output::{format_seconds, note, print, print_json};
use crate::search::search_path;
use pliant_host::{Library, PluginInfo, protected_memory};
use pliant_plugin_api::kit::{Kind, ProtectedMemory, Verdict, cases};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The one case that is about the library and not about a plugin in it, and its promise.
const OPENING: (&str, &str) =
    ("opens-under-100-ms", "the library opens in at most 100 ms, so that listing plugins is not delayed by it");
/// Longest allowed time to open a library, s.
const OPENING_SECONDS: f64 = 0.1;
/// Memory for an array of a test body between pages without access, bytes.
const PROTECTED_BYTES: usize = 1 << 20;
/// Number of times opening is timed; the shortest counts, as a busy machine is not the library's fault.
const OPENINGS: usize = 3;

/// Runs the whole suite, or, in a child process, the one task that `--child` gives.
pub fn check(cli: &Cli, args: &CheckArgs) -> Result<Outcome, Failure> {
    let path = find_library(cli, &args.file)?;
    match &args.child {
        Some(task) => run_in_child(&path, task),
        None => check_all(cli, args, &path),
    }
}

/// Path of the file itself, or of the library with that name.
fn find_library(cli: &Cli, file: &Path) -> Result<PathBuf, Failure> {
    if file.is_file() {
        return file.canonicalize().map_err(Failure::from);
    }
    let name = file.to_string_lossy();
    Ok(search_path(cli)?.find_trusted(&name, Path::new("."))?.path)
}

/// In a child: times the opening and lists the plugins, or runs one case.
fn run_in_child(path: &Path, task: &str) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let library = Library::open(path)?;
    if task == "list" {
        let seconds = start.elapsed().as_secs_f64();
        let row = |p: &PluginInfo| json!({ "id": p.id, "kind": p.kind.name() });
        let plugins: Vec<Value> = library.plugins().iter().map(row).collect();
        print(&json!({ "seconds": seconds, "plugins": plugins }).to_string())?;
        return Ok(Outcome::Done);
    }
    let unknown = || Failure::input(format!("no case `{task}`; allowed is `list` or INDEX/CASE"));
    let (index, name) = task.split_once('/').ok_or_else(unknown)?;
    let index = index.parse().ok().filter(|i| *i < library.plugins().len()).ok_or_else(unknown)?;
    let mut candidate = library.candidate(index);
    if let Ok(memory) = protected_memory(PROTECTED_BYTES) {
        candidate = candidate.with_protected_memory(ProtectedMemory::new(memory, announce));
    }
    let kind = candidate.kind().ok_or_else(unknown)?;
    let case = cases(kind).into_iter().find(|c| c.name == name).ok_or_else(unknown)?;
    let (verdict, why) = match case.run(&candidate) {
        Verdict::Passed => ("ok", String::new()),
        Verdict::Skipped(why) => ("skipped", why),
        Verdict::Failed(why) => ("FAILED", why),
    };
    print(&json!({ "verdict": verdict, "why": why }).to_string())?;
    Ok(Outcome::Done)
}

/// Tells the parent what a call did if it ends this process. A parent that has gone away is met again with the verdict.
fn announce(call: &str) {
    let _ = print(&json!({ "ended_by": call }).to_string());
}

/// Runs every wanted case of every wanted plugin in a child.
fn check_all(cli: &Cli, args: &CheckArgs, path: &Path) -> Result<Outcome, Failure> {
    let limit = Duration::from_secs_f64(args.seconds.clamp(0.1, 1e6));
    let (mut plugins, mut fastest) = (Vec::new(), f64::INFINITY);
    for _ in 0..OPENINGS {
        let answer = ask_child(path, "list", limit);
        let answer = answer.map_err(|why| Failure::plugin(format!("{}: {why}", path.display())))?;
        plugins = answer["plugins"].as_array().cloned().unwrap_or_default();
        fastest = answer["seconds"].as_f64().unwrap_or(f64::INFINITY).min(fastest);
    }
    let is_wanted = |case: &str| args.case.as_deref().is_none_or(|wanted| wanted == case);
    let mut report = Report { json: cli.json, rows: Vec::new(), passed: 0, skipped: 0, failed: 0 };
    if is_wanted(OPENING.0) {
        let late = fastest > OPENING_SECONDS;
        let why = if late { format!("it took {}", format_seconds(fastest)) } else { String::new() };
        let verdict = if late { "FAILED" } else { "ok" }.to_owned();
        report.add(CaseResult { plugin: "", case: OPENING.0, promise: OPENING.1, verdict, why })?;
    }
    for (index, plugin) in plugins.iter().enumerate() {
        let [id, kind_name] = ["id", "kind"].map(|key| plugin[key].as_str().unwrap_or_default());
        if args.id.as_deref().is_some_and(|wanted| wanted != id) {
            continue;
        }
        let kind = match kind_name {
            "grid" => Kind::Grid,
            "device" => Kind::Device,
            "contact-law" => Kind::ContactLaw,
            "material" => Kind::Material,
            other => {
                return Err(Failure::plugin(format!("{}: `{id}` is of unknown kind `{other}`", path.display())));
            }
        };
        if !cli.json {
            print(&format!("{kind_name} `{id}`"))?;
        }
        for case in cases(kind).iter().filter(|c| is_wanted(c.name)) {
            let (verdict, why) = match ask_child(path, &format!("{index}/{}", case.name), limit) {
                Ok(answer) => {
                    let text = |key: &str| answer[key].as_str().unwrap_or_default().to_owned();
                    (text("verdict"), text("why"))
                }
                Err(why) => ("FAILED".into(), why),
            };
            report.add(CaseResult { plugin: id, case: case.name, promise: case.promise, verdict, why })?;
        }
    }
    report.finish(path)
}

/// Verdict of one case.
struct CaseResult<'a> {
    /// Id of the plugin; empty for the library.
    plugin: &'a str,
    case: &'a str,
    /// What the case holds the plugin to.
    promise: &'a str,
    /// `ok`, `skipped` or `FAILED`.
    verdict: String,
    /// Why it was skipped or failed.
    why: String,
}

/// The verdicts so far.
struct Report {
    /// Whether rows are printed at the end as JSON, not one by one.
    json: bool,
    rows: Vec<Value>,
    passed: usize,
    skipped: usize,
    failed: usize,
}

impl Report {
    /// Adds a verdict, and prints it if the report is for people.
    fn add(&mut self, result: CaseResult<'_>) -> Result<(), Failure> {
        let CaseResult { plugin, case, promise, verdict, why } = result;
        match verdict.as_str() {
            "ok" => self.passed += 1,
            "skipped" => self.skipped += 1,
            _ => self.failed += 1,
        }
        self.rows.push(json!({ "plugin": plugin, "case": case, "promise": promise, "verdict": verdict, "why": why }));
        if self.json {
            return Ok(());
        }
        let why = if why.is_empty() { String::new() } else { format!(": {why}") };
        Ok(print(&format!("  {verdict:<8} {case}: {promise}{why}"))?)
    }

    /// Prints the counts, or the whole report as JSON.
    fn finish(self, path: &Path) -> Result<Outcome, Failure> {
        let Self { json, rows, passed, skipped, failed } = self;
        if rows.is_empty() {
            return Err(Failure::input(format!(
                "{}: no plugin with that id, or no case with that name",
                path.display()
            )));
        }
        if json {
            print_json(
                &json!({ "path": path.display().to_string(), "cases": rows, "ok": passed, "skipped": skipped, "failed": failed }),
            )?;
        } else {
            note(&format!("{passed} ok, {skipped} skipped, {failed} failed"));
        }
        Ok(if failed > 0 { Outcome::CheckFailed } else { Outcome::Done })
    }
}

/// The answer of a child to a task, or why it gave none within `limit`.
fn ask_child(path: &Path, task: &str, limit: Duration) -> Result<Value, String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let mut command = Command::new(program);
    command.args(["plugin", "check"]).arg(path).args(["--child", task]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    match run_to_end(&mut command, Some(limit)) {
        ChildEnd::Exited { code: 0, stdout, .. } => {
            let answer = stdout.lines().last().and_then(|line| serde_json::from_str(line).ok());
            answer.ok_or_else(|| "the process gave no answer that can be read".into())
        }
        ChildEnd::Exited { code, stderr, .. } => {
            let said = stderr.lines().next_back().unwrap_or_default().trim_start_matches("error: ").to_owned();
            Err(if said.is_empty() { format!("the process ended with code {code}") } else { said })
        }
        ChildEnd::Signalled { how, stdout } => {
            let last = stdout.lines().last().and_then(|line| serde_json::from_str::<Value>(line).ok());
            let call = last.as_ref().and_then(|last| last["ended_by"].as_str()).map(|call| format!("{call}: "));
            Err(format!("{}the process was ended by {how}", call.unwrap_or_default()))
        }
        end @ (ChildEnd::TimedOut { .. } | ChildEnd::NotStarted(_)) => Err(end.to_string()),
    }
}
