//! `pliant plugin check`: runs the conformance suite on a library, with a process and a line for each case.
//!
//! This process never opens the library: each case runs in a child, so a plugin that crashes or hangs fails its case and nothing else. A
//! child is this program with `--child list`, which measures the opening time and lists the plugins, or `--child INDEX/CASE`, which runs a case; it answers
//! with a line of JSON. Before each call that might hit a guard page the child prints `{"ended_by": CALL}`; if the child is killed, the parent
//! reports that call.

use crate::args::{CheckArgs, Cli};
use crate::child::{ChildEnd, run_to_end};
use crate::outcome::{Failure, Outcome};
use crate::output::{format_seconds, note, print, print_json};
use crate::search::search_path;
use pliant_host::{Library, PluginInfo, PluginKind, protected_memory};
use pliant_plugin_api::kit::{Kind, ProtectedMemory, Verdict, cases};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Name and promise of the only case that tests the library itself.
const OPEN_TIME_CASE: (&str, &str) =
    ("opens-under-100-ms", "the library opens in at most 100 ms, so that listing plugins is not delayed by it");
/// Longest allowed time to open a library, s.
const MAX_OPEN_SECONDS: f64 = 0.1;
/// Size of the guard-paged buffer for one array, bytes: it holds the matrices (12 x 12) of 900 tetrahedra, more than a test body has. A longer
/// array would lie between guard values instead.
const GUARDED_BYTES: usize = 1 << 20;
/// Number of times the opening time is measured; the shortest counts, as a busy machine is not the library's fault.
const OPEN_TIME_SAMPLES: usize = 3;

/// Answer of a child to `list`.
#[derive(Serialize, Deserialize)]
struct Listing {
    /// Time to open the library, s.
    seconds: f64,
    plugins: Vec<ListedPlugin>,
}

/// A plugin of the library.
#[derive(Serialize, Deserialize)]
struct ListedPlugin {
    id: String,
    /// Name of the kind ([`PluginKind::name`]).
    kind: String,
}

/// Answer of a child to `INDEX/CASE`.
#[derive(Serialize, Deserialize)]
struct CaseAnswer {
    verdict: VerdictName,
    /// Why the case was skipped or failed; empty if it passed.
    why: String,
}

/// Verdict of a case, without its reason.
#[derive(Clone, Copy, Serialize, Deserialize)]
enum VerdictName {
    #[serde(rename = "ok")]
    Passed,
    #[serde(rename = "skipped")]
    Skipped,
    #[serde(rename = "FAILED")]
    Failed,
}

impl VerdictName {
    /// Name in the report for people, the same as in JSON.
    fn name(self) -> &'static str {
        match self {
            Self::Passed => "ok",
            Self::Skipped => "skipped",
            Self::Failed => "FAILED",
        }
    }
}

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

/// Child process: measures the opening time and lists the plugins, or runs one case.
fn run_in_child(path: &Path, task: &str) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let library = Library::open(path)?;
    if task == "list" {
        let seconds = start.elapsed().as_secs_f64();
        let listed = |p: &PluginInfo| ListedPlugin { id: p.id.clone(), kind: p.kind.name().to_owned() };
        print_answer(&Listing { seconds, plugins: library.plugins().iter().map(listed).collect() })?;
        return Ok(Outcome::Done);
    }
    let unknown = || Failure::input(format!("no case `{task}`; allowed is `list` or INDEX/CASE"));
    let (index, name) = task.split_once('/').ok_or_else(unknown)?;
    let index = index.parse().ok().filter(|i| *i < library.plugins().len()).ok_or_else(unknown)?;
    let mut candidate = library.candidate(index);
    if let Ok(memory) = protected_memory(GUARDED_BYTES) {
        candidate = candidate.with_protected_memory(ProtectedMemory::new(memory, announce));
    }
    let unknown_kind =
        || Failure::plugin(format!("{}: plugin {index} is of a kind that this host does not know", path.display()));
    let kind = candidate.kind().ok_or_else(unknown_kind)?;
    let case = cases(kind).into_iter().find(|c| c.name == name).ok_or_else(unknown)?;
    let (verdict, why) = match case.run(&candidate) {
        Verdict::Passed => (VerdictName::Passed, String::new()),
        Verdict::Skipped(why) => (VerdictName::Skipped, why),
        Verdict::Failed(why) => (VerdictName::Failed, why),
    };
    print_answer(&CaseAnswer { verdict, why })?;
    Ok(Outcome::Done)
}

/// Prints the answer of a child on one line.
fn print_answer(answer: &impl Serialize) -> std::io::Result<()> {
    print(&serde_json::to_string(answer).map_err(std::io::Error::other)?)
}

/// Prints the name of the next call, so the parent can name it if the process dies. A write error is ignored: printing the verdict reports it.
fn announce(call: &str) {
    let _ = print(&json!({ "ended_by": call }).to_string());
}

/// Runs every wanted case of every wanted plugin in a child.
fn check_all(cli: &Cli, args: &CheckArgs, path: &Path) -> Result<Outcome, Failure> {
    let limit = Duration::from_secs_f64(args.seconds);
    let (mut plugins, mut fastest) = (Vec::new(), f64::INFINITY);
    for _ in 0..OPEN_TIME_SAMPLES {
        let answer: Result<Listing, String> = ask_child(path, "list", limit);
        let listing = answer.map_err(|why| Failure::plugin(format!("{}: {why}", path.display())))?;
        plugins = listing.plugins;
        fastest = fastest.min(listing.seconds);
    }
    let is_checked = |plugin: &ListedPlugin| args.id.as_deref().is_none_or(|wanted| wanted == plugin.id);
    if let Some(id) = args.id.as_deref().filter(|_| !plugins.iter().any(is_checked)) {
        let known: Vec<&str> = plugins.iter().map(|plugin| plugin.id.as_str()).collect();
        let text = format!("{}: no plugin `{id}`; allowed: {}", path.display(), known.join(", "));
        return Err(Failure::input(text));
    }
    let is_wanted = |case: &str| args.case.as_deref().is_none_or(|wanted| wanted == case);
    let mut report = Report { json: cli.json, rows: Vec::new(), passed: 0, skipped: 0, failed: 0 };
    let (name, promise) = OPEN_TIME_CASE;
    if is_wanted(name) {
        let too_slow = fastest > MAX_OPEN_SECONDS;
        let why = if too_slow { format!("it took {}", format_seconds(fastest)) } else { String::new() };
        let verdict = if too_slow { VerdictName::Failed } else { VerdictName::Passed };
        report.add(CaseResult { plugin: "", case: name, promise, answer: CaseAnswer { verdict, why } })?;
    }
    let mut known_cases = vec![name];
    for (index, plugin) in plugins.iter().enumerate().filter(|(_, plugin)| is_checked(plugin)) {
        let ListedPlugin { id, kind: kind_name } = plugin;
        let kind = PluginKind::from_name(kind_name)
            .ok_or_else(|| Failure::plugin(format!("{}: `{id}` is of unknown kind `{kind_name}`", path.display())))?;
        if !cli.json {
            print(&format!("{kind_name} `{id}`"))?;
        }
        for case in cases(suite_kind(kind)) {
            known_cases.push(case.name);
            if is_wanted(case.name) {
                let answer = ask_child(path, &format!("{index}/{}", case.name), limit);
                let answer = answer.unwrap_or_else(|why| CaseAnswer { verdict: VerdictName::Failed, why });
                report.add(CaseResult { plugin: id, case: case.name, promise: case.promise, answer })?;
            }
        }
    }
    if let Some(case) = args.case.as_deref().filter(|case| !known_cases.contains(case)) {
        known_cases.sort_unstable();
        known_cases.dedup();
        let text = format!("{}: no case `{case}`; allowed: {}", path.display(), known_cases.join(", "));
        return Err(Failure::input(text));
    }
    report.finish(path)
}

/// The kind of a plugin in the conformance suite.
fn suite_kind(kind: PluginKind) -> Kind {
    match kind {
        PluginKind::Grid => Kind::Grid,
        PluginKind::Material => Kind::Material,
        PluginKind::Device => Kind::Device,
        PluginKind::ContactLaw => Kind::ContactLaw,
    }
}

/// Verdict of one case.
struct CaseResult<'a> {
    /// Id of the plugin; empty for the library.
    plugin: &'a str,
    case: &'a str,
    /// The promise that the case tests.
    promise: &'a str,
    answer: CaseAnswer,
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
        let CaseResult { plugin, case, promise, answer: CaseAnswer { verdict, why } } = result;
        match verdict {
            VerdictName::Passed => self.passed += 1,
            VerdictName::Skipped => self.skipped += 1,
            VerdictName::Failed => self.failed += 1,
        }
        self.rows.push(json!({ "plugin": plugin, "case": case, "promise": promise, "verdict": verdict, "why": why }));
        if self.json {
            return Ok(());
        }
        let why = if why.is_empty() { String::new() } else { format!(": {why}") };
        Ok(print(&format!("  {:<8} {case}: {promise}{why}", verdict.name()))?)
    }

    /// Prints the counts, or the whole report as JSON.
    fn finish(self, path: &Path) -> Result<Outcome, Failure> {
        let Self { json, rows, passed, skipped, failed } = self;
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
fn ask_child<T: DeserializeOwned>(path: &Path, task: &str, limit: Duration) -> Result<T, String> {
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
            let message = stderr.lines().next_back().unwrap_or_default().trim_start_matches("error: ").to_owned();
            Err(if message.is_empty() { format!("the process ended with code {code}") } else { message })
        }
        ChildEnd::Signalled { signal, stdout } => {
            let last = stdout.lines().last().and_then(|line| serde_json::from_str::<Value>(line).ok());
            let call = last.as_ref().and_then(|last| last["ended_by"].as_str()).map(|call| format!("{call}: "));
            Err(format!("{}the process was ended by {signal}", call.unwrap_or_default()))
        }
        end @ (ChildEnd::TimedOut { .. } | ChildEnd::NotStarted(_)) => Err(end.to_string()),
    }
}
