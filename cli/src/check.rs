//! `pliant plugin check`: the conformance suite on a library, a process and a sentence a case.
//!
//! The library is never opened in this process: each case runs in a child, so a plugin that crashes or hangs fails its case
//! and nothing else.

use crate::args::{CheckArgs, Cli};
use crate::child::{Ended, wait};
use crate::outcome::{Failure, Outcome};
use crate::text;
use pliant_host::{Library, SearchPath};
use pliant_plugin_api::kit::{Kind, Verdict, cases};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The one case about the library and not about a plugin in it.
const OPENING: (&str, &str) = ("opens-under-100-ms", "a program that lists plugins does not wait for this one");
const OPENING_SECONDS: f64 = 0.1;

pub fn check(cli: &Cli, args: &CheckArgs) -> Result<Outcome, Failure> {
    let path = find(cli, &args.file)?;
    match &args.child {
        Some(what) => child(&path, what),
        None => parent(cli, args, &path),
    }
}

/// The file itself, or the library of that name.
fn find(cli: &Cli, file: &Path) -> Result<PathBuf, Failure> {
    if file.is_file() {
        return file.canonicalize().map_err(Failure::from);
    }
    let name = file.to_string_lossy();
    Ok(SearchPath::new(&cli.plugin_path).find(&name, Path::new("."))?.path)
}

/// In the child: `list`, or `PLACE/CASE`.
fn child(path: &Path, what: &str) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let library = Library::open(path)?;
    if what == "list" {
        let seconds = start.elapsed().as_secs_f64();
        let row = |p: &pliant_host::PluginInfo| json!({ "id": p.id, "kind": p.kind.name() });
        let plugins: Vec<Value> = library.plugins().iter().map(row).collect();
        return text::out(&json!({ "seconds": seconds, "plugins": plugins }).to_string());
    }
    let unknown = || Failure::input(format!("no case `{what}`"));
    let (place, name) = what.split_once('/').ok_or_else(unknown)?;
    let place = place.parse().ok().filter(|p| *p < library.plugins().len()).ok_or_else(unknown)?;
    let candidate = library.candidate(place);
    let kind = candidate.kind().ok_or_else(unknown)?;
    let case = cases(kind).into_iter().find(|c| c.name == name).ok_or_else(unknown)?;
    let (verdict, why) = match case.run(&candidate) {
        Verdict::Passed => ("ok", String::new()),
        Verdict::Skipped(why) => ("skipped", why),
        Verdict::Failed(why) => ("FAILED", why),
    };
    text::out(&json!({ "verdict": verdict, "why": why }).to_string())
}

fn parent(cli: &Cli, args: &CheckArgs, path: &Path) -> Result<Outcome, Failure> {
    let seconds = Duration::from_secs_f64(args.seconds.clamp(0.1, 1e6));
    // The quickest of three: a busy machine is not the library's fault.
    let (mut plugins, mut quickest) = (Vec::new(), f64::INFINITY);
    for _ in 0..3 {
        let (answer, why) = run(path, "list", seconds);
        let answer = answer.ok_or_else(|| Failure::plugin(format!("{}: {why}", path.display())))?;
        plugins = answer["plugins"].as_array().cloned().unwrap_or_default();
        quickest = answer["seconds"].as_f64().unwrap_or(f64::INFINITY).min(quickest);
    }
    let mut report = Report { json: cli.json, rows: Vec::new(), counts: [0; 3] };
    if args.case.as_deref().is_none_or(|wanted| wanted == OPENING.0) {
        let late = quickest > OPENING_SECONDS;
        let why = if late { format!("it took {}", text::seconds(quickest)) } else { String::new() };
        report.add("", OPENING, if late { "FAILED" } else { "ok" }, &why)?;
    }
    for (place, plugin) in plugins.iter().enumerate() {
        let id = plugin["id"].as_str().unwrap_or_default();
        if args.id.as_deref().is_some_and(|wanted| wanted != id) {
            continue;
        }
        let kind = match plugin["kind"].as_str() {
            Some("grid") => Kind::Grid,
            Some("device") => Kind::Device,
            _ => Kind::Material,
        };
        if !cli.json {
            text::out(&format!("{} `{id}`", plugin["kind"].as_str().unwrap_or("plugin")))?;
        }
        for case in cases(kind).iter().filter(|c| args.case.as_deref().is_none_or(|wanted| wanted == c.name)) {
            let (verdict, why) = match run(path, &format!("{place}/{}", case.name), seconds) {
                (Some(answer), _) => {
                    let text = |key: &str| answer[key].as_str().unwrap_or_default().to_owned();
                    (text("verdict"), text("why"))
                }
                (None, why) => ("FAILED".into(), why),
            };
            report.add(id, (case.name, case.promise), &verdict, &why)?;
        }
    }
    let Report { rows, counts: [ok, skipped, failed], .. } = report;
    if rows.is_empty() {
        return Err(Failure::input(format!("{}: no such plugin or case in it", path.display())));
    }
    if cli.json {
        let document = json!({ "path": path, "cases": rows, "ok": ok, "skipped": skipped, "failed": failed });
        text::out(&crate::pretty(&document))?;
    } else {
        text::note(&format!("{ok} ok, {skipped} skipped, {failed} failed"));
    }
    Ok(if failed > 0 { Outcome::CheckFailed } else { Outcome::Done })
}

/// Sentences so far.
struct Report {
    json: bool,
    rows: Vec<Value>,
    counts: [usize; 3],
}

impl Report {
    fn add(
        &mut self,
        plugin: &str,
        (case, promise): (&str, &str),
        verdict: &str,
        why: &str,
    ) -> Result<Outcome, Failure> {
        self.counts[["ok", "skipped"].iter().position(|v| *v == verdict).unwrap_or(2)] += 1;
        self.rows.push(json!({ "plugin": plugin, "case": case, "promise": promise, "verdict": verdict, "why": why }));
        if self.json {
            return Ok(Outcome::Done);
        }
        let why = if why.is_empty() { String::new() } else { format!(": {why}") };
        text::out(&format!("  {verdict:<8} {case}: {promise}{why}"))
    }
}

/// The last line a child said, or why there is none.
fn run(path: &Path, what: &str, seconds: Duration) -> (Option<Value>, String) {
    let program = match std::env::current_exe() {
        Ok(program) => program,
        Err(error) => return (None, error.to_string()),
    };
    let mut command = Command::new(program);
    command.args(["plugin", "check"]).arg(path).args(["--child", what]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    match wait(&mut command, Some(seconds)) {
        Ended::Code(0, out, _) => {
            let answer = out.lines().last().and_then(|line| serde_json::from_str(line).ok());
            let why = if answer.is_none() { "it said nothing that can be read" } else { "" };
            (answer, why.into())
        }
        Ended::Code(code, _, err) => {
            let said = err.lines().next_back().unwrap_or_default().trim_start_matches("error: ").to_owned();
            (None, if said.is_empty() { format!("the process ended with code {code}") } else { said })
        }
        other => (None, other.to_string()),
    }
}
