//! `pliant plugin`.

use crate::args::{Cli, PluginCommand};
use crate::outcome::{Failure, Outcome};
use crate::text;
use pliant_host::{ChoiceSource, Library, ParamInfo, ParamKind, PluginInfo, PluginKind, SearchPath, choice_sources};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

pub fn plugin(cli: &Cli, what: &PluginCommand) -> Result<Outcome, Failure> {
    let search = SearchPath::new(&cli.plugin_path);
    match what {
        PluginCommand::List => list(cli, &search),
        PluginCommand::Info { name } => info(cli, &search, name),
        PluginCommand::New(args) => crate::new::new(cli, args),
        PluginCommand::Check(args) => crate::check::check(cli, args),
    }
}

/// Every library that is found; one that cannot be opened is listed with its reason, and the exit code says so.
fn list(cli: &Cli, search: &SearchPath) -> Result<Outcome, Failure> {
    let (mut rows, mut lines, mut outcome) = (Vec::new(), Vec::new(), Outcome::Done);
    for found in search.scan() {
        match Library::open(&found.path) {
            Ok(library) => {
                for p in library.plugins() {
                    lines.push(format!("{:<9} {:<20} {:<8} {}", p.kind.name(), p.id, p.version, found.path.display()));
                    rows.push(describe(p, &found.path, &[]));
                }
            }
            Err(error) => {
                outcome = Outcome::Plugin;
                lines.push(format!("{:<9} {:<20} {:<8} {error}", "unusable", found.name, "-"));
                rows.push(json!({ "name": found.name, "path": found.path, "error": error.to_string() }));
            }
        }
    }
    if lines.is_empty() {
        lines.push("no plugins found".into());
    }
    let document = if cli.json { crate::pretty(&json!({ "plugins": rows })) } else { lines.join("\n") };
    text::out(&document).map(|_| outcome)
}

fn info(cli: &Cli, search: &SearchPath, name: &str) -> Result<Outcome, Failure> {
    let found = search.find(name, Path::new("."))?;
    let library = Library::open(&found.path)?;
    if cli.json {
        let rows: Vec<Value> = library.plugins().iter().map(|p| describe(p, &found.path, &cited(library, p))).collect();
        return text::out(&crate::pretty(&json!({ "plugins": rows })));
    }
    let mut lines = Vec::new();
    for p in library.plugins() {
        lines.push(format!("{} `{}` {}: {}", p.kind.name(), p.id, p.version, p.name));
        lines.push(format!("  {}", p.summary));
        lines.push(format!("  {}", found.path.display()));
        let cited = cited(library, p);
        for (place, param) in p.params.iter().enumerate() {
            lines.push(format!("  {:<18} {}", param.key, param.summary));
            lines.push(format!("  {:<18}   {}{}", "", param.allowed(), default(param)));
            for (choices, source) in by_source(place, param, &cited) {
                lines.push(format!("  {:<18}   {}: {}", "", choices.join(", "), source.source));
                if !source.unknown.is_empty() {
                    lines.push(format!("  {:<18}     not known: {}", "", source.unknown));
                }
            }
        }
    }
    text::out(&lines.join("\n"))
}

/// Where the numbers behind a plugin's choices come from. One that cannot say is listed all the same.
fn cited(library: &'static Library, p: &PluginInfo) -> Vec<ChoiceSource> {
    if p.kind == PluginKind::Material { choice_sources(library, &p.id).unwrap_or_default() } else { Vec::new() }
}

/// The choices of a parameter that share a source, with it.
fn by_source<'a>(place: usize, param: &'a ParamInfo, all: &'a [ChoiceSource]) -> Vec<(Vec<&'a str>, &'a ChoiceSource)> {
    let ParamKind::Choice { choices, .. } = &param.kind else { return Vec::new() };
    let mut groups: Vec<(Vec<&str>, &ChoiceSource)> = Vec::new();
    for one in all.iter().filter(|one| one.param == place) {
        let Some(name) = choices.get(one.choice) else { continue };
        match groups.last_mut().filter(|(_, s)| (&s.source, &s.unknown) == (&one.source, &one.unknown)) {
            Some((names, _)) => names.push(name),
            None => groups.push((vec![name], one)),
        }
    }
    groups
}

fn default(param: &ParamInfo) -> String {
    match &param.kind {
        ParamKind::Number { default, .. } => format!("; default {default}"),
        ParamKind::Choice { choices, default } => format!("; default {}", choices[*default]),
        _ => String::new(),
    }
}

fn describe(p: &PluginInfo, path: &Path, cited: &[ChoiceSource]) -> Value {
    let param = |(place, q): (usize, &ParamInfo)| {
        let mut row = json!({ "key": q.key, "unit": q.unit, "summary": q.summary });
        match &q.kind {
            ParamKind::Number { min, max, default } => {
                row["type"] = "number".into();
                row["min"] = json!(min);
                row["max"] = json!(max);
                row["default"] = json!(default);
            }
            ParamKind::Choice { choices, default } => {
                row["type"] = "choice".into();
                row["choices"] = json!(choices);
                let of = cited.iter().filter(|one| one.param == place && one.choice < choices.len());
                let of: BTreeMap<&str, Value> = of
                    .map(|one| (&*choices[one.choice], json!({ "source": one.source, "unknown": one.unknown })))
                    .collect();
                if !of.is_empty() {
                    row["sources"] = json!(of);
                }
                row["default"] = json!(choices[*default]);
            }
            ParamKind::Text => row["type"] = "text".into(),
            ParamKind::Path => row["type"] = "path".into(),
            ParamKind::Table { columns } => {
                row["type"] = "table".into();
                row["columns"] = json!(columns);
            }
        }
        row
    };
    json!({
        "kind": p.kind.name(),
        "id": p.id,
        "name": p.name,
        "version": p.version,
        "summary": p.summary,
        "path": path,
        "real_time": p.real_time,
        "deterministic": p.deterministic,
        "params": p.params.iter().enumerate().map(param).collect::<Vec<_>>(),
    })
}
