//! `pliant plugin`.

use crate::args::{Cli, PluginCommand};
use crate::outcome::{Failure, Outcome};
use crate::text;
use pliant_core::host::{Library, ParamInfo, ParamKind, PluginInfo, Search};
use serde_json::{Value, json};
use std::path::Path;

pub fn plugin(cli: &Cli, what: &PluginCommand) -> Result<Outcome, Failure> {
    let search = Search::new(&cli.plugin_path);
    match what {
        PluginCommand::List => list(cli, &search),
        PluginCommand::Info { name } => info(cli, &search, name),
        PluginCommand::New(args) => crate::new::new(cli, args),
        PluginCommand::Check(args) => crate::check::check(cli, args),
    }
}

/// Every library that is found; one that cannot be opened is listed with its reason, and the exit code says so.
fn list(cli: &Cli, search: &Search) -> Result<Outcome, Failure> {
    let (mut rows, mut lines, mut outcome) = (Vec::new(), Vec::new(), Outcome::Done);
    for found in search.scan() {
        match Library::open(&found.path) {
            Ok(library) => {
                for p in library.plugins() {
                    lines.push(format!("{:<9} {:<20} {:<8} {}", p.kind.name(), p.id, p.version, found.path.display()));
                    rows.push(describe(p, &found.path));
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

fn info(cli: &Cli, search: &Search, name: &str) -> Result<Outcome, Failure> {
    let found = search.find(name, Path::new("."))?;
    let library = Library::open(&found.path)?;
    if cli.json {
        let rows: Vec<Value> = library.plugins().iter().map(|p| describe(p, &found.path)).collect();
        return text::out(&crate::pretty(&json!({ "plugins": rows })));
    }
    let mut lines = Vec::new();
    for p in library.plugins() {
        lines.push(format!("{} `{}` {}: {}", p.kind.name(), p.id, p.version, p.name));
        lines.push(format!("  {}", p.summary));
        lines.push(format!("  {}", found.path.display()));
        for param in &p.params {
            lines.push(format!("  {:<18} {}", param.key, param.summary));
            lines.push(format!("  {:<18}   {}{}", "", param.takes(), default(param)));
        }
    }
    text::out(&lines.join("\n"))
}

fn default(param: &ParamInfo) -> String {
    match &param.kind {
        ParamKind::Number { default, .. } => format!("; default {default}"),
        ParamKind::Choice { choices, default } => format!("; default {}", choices[*default]),
        _ => String::new(),
    }
}

fn describe(p: &PluginInfo, path: &Path) -> Value {
    let param = |q: &ParamInfo| {
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
        "params": p.params.iter().map(param).collect::<Vec<_>>(),
    })
}
