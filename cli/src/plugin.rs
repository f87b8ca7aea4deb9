//! `pliant plugin`.

use crate::args::{Cli, InfoArgs, PluginCommand};
use crate::check::check;
use crate::new::new;
use crate::outcome::{Failure, Outcome};
use crate::output::{print, print_json};
use crate::search::search_path;
use crate::survey::{Surveyed, answer, ask, survey};
use pliant_host::{ChoiceSource, Library, ParamInfo, ParamKind, PluginInfo, PluginKind, SearchPath, choice_sources};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// Lists plugins, shows one, begins one, or checks one.
pub fn plugin(cli: &Cli, command: &PluginCommand) -> Result<Outcome, Failure> {
    match command {
        PluginCommand::List(args) if !args.child.is_empty() => answer(&args.child, plugins_json),
        PluginCommand::Info(InfoArgs { child: Some(path), .. }) => answer(std::slice::from_ref(path), description_json),
        PluginCommand::List(_) => list(cli, &search_path(cli)?),
        PluginCommand::Info(args) => info(cli, &search_path(cli)?, args),
        PluginCommand::New(args) => new(cli, args),
        PluginCommand::Check(args) => check(cli, args),
    }
}

/// `pliant plugin list`. A library that cannot be opened is listed with the reason, and the exit code is 3.
fn list(cli: &Cli, search: &SearchPath) -> Result<Outcome, Failure> {
    let (mut rows, mut lines, mut outcome) = (Vec::new(), Vec::new(), Outcome::Done);
    for Surveyed { found, answer } in survey(search.scan(), ["plugin", "list"])? {
        match answer {
            Ok(plugins) => {
                for plugin in plugins.as_array().into_iter().flatten() {
                    let [kind, id, version] = ["kind", "id", "version"].map(|key| plugin[key].as_str().unwrap_or("-"));
                    lines.push(format!("{kind:<11} {id:<20} {version:<8} {}", found.path.display()));
                    rows.push(plugin.clone());
                }
            }
            Err(error) => {
                outcome = Outcome::Plugin;
                lines.push(format!("{:<11} {:<20} {:<8} {}", "unusable", found.name, "-", error.text));
                rows.push(json!({ "name": found.name, "path": found.path.display().to_string(), "error": error.text }));
            }
        }
    }
    if lines.is_empty() {
        lines.push("no plugins found".into());
    }
    if cli.json {
        print_json(&json!({ "plugins": rows }))?;
    } else {
        print(&lines.join("\n"))?;
    }
    Ok(outcome)
}

/// The plugins of a library as JSON.
fn plugins_json(library: &'static Library, path: &Path) -> Result<Value, Failure> {
    Ok(library.plugins().iter().map(|plugin| plugin_json(plugin, path, &[])).collect())
}

/// `pliant plugin info`. A child opens the library and describes it.
fn info(cli: &Cli, search: &SearchPath, args: &InfoArgs) -> Result<Outcome, Failure> {
    let found = search.find_trusted(&args.name, Path::new("."))?;
    let description = ask(&found, &["plugin", "info", &args.name], args.limit.duration())?;
    if cli.json {
        print_json(&json!({ "plugins": description["plugins"] }))?;
    } else {
        print(description["text"].as_str().unwrap_or_default())?;
    }
    Ok(Outcome::Done)
}

/// What `plugin info` says of a library: its plugins with the sources of their values, and the same as people read it.
fn description_json(library: &'static Library, path: &Path) -> Result<Value, Failure> {
    let (mut plugins, mut lines) = (Vec::new(), Vec::new());
    for plugin in library.plugins() {
        let sources = sources_of(library, plugin);
        plugins.push(plugin_json(plugin, path, &sources));
        lines.extend(plugin_lines(plugin, path, &sources));
    }
    Ok(json!({ "plugins": plugins, "text": lines.join("\n") }))
}

/// A plugin as people read it.
fn plugin_lines(p: &PluginInfo, path: &Path, sources: &[ChoiceSource]) -> Vec<String> {
    let mut lines = vec![
        format!("{} `{}` {}: {}", p.kind.name(), p.id, p.version, p.name),
        format!("  {}", p.summary),
        format!("  {}", path.display()),
    ];
    if p.whole_lists {
        lines.push("  gets whole lists: all elements of a kind in each call, and one call at a time".into());
    }
    for (index, param) in p.params.iter().enumerate() {
        lines.push(format!("  {:<18} {}", param.key, param.summary));
        lines.push(format!("  {:<18}   {}{}", "", param.allowed(), default_text(param)));
        for group in group_by_source(index, param, sources) {
            lines.push(format!("  {:<18}   {}: {}", "", group.choices.join(", "), group.source.source));
            if !group.source.unknown.is_empty() {
                lines.push(format!("  {:<18}     not known: {}", "", group.source.unknown));
            }
        }
    }
    lines
}

/// Sources of the values behind a material's choices; empty where the plugin has none or fails.
fn sources_of(library: &'static Library, p: &PluginInfo) -> Vec<ChoiceSource> {
    match p.kind {
        PluginKind::Material => choice_sources(library, &p.id).unwrap_or_default(),
        PluginKind::Grid | PluginKind::Device | PluginKind::ContactLaw => Vec::new(),
    }
}

/// Choices of a parameter that share a source.
struct SourceGroup<'a> {
    choices: Vec<&'a str>,
    source: &'a ChoiceSource,
}

/// The sources of a parameter's choices, each with the neighbouring choices that share it.
fn group_by_source<'a>(index: usize, param: &'a ParamInfo, all: &'a [ChoiceSource]) -> Vec<SourceGroup<'a>> {
    let ParamKind::Choice { choices, .. } = &param.kind else { return Vec::new() };
    let mut groups: Vec<SourceGroup<'_>> = Vec::new();
    for source in all.iter().filter(|source| source.param == index) {
        let Some(name) = choices.get(source.choice) else { continue };
        let shared =
            |g: &&mut SourceGroup<'_>| (&g.source.source, &g.source.unknown) == (&source.source, &source.unknown);
        match groups.last_mut().filter(shared) {
            Some(group) => group.choices.push(name),
            None => groups.push(SourceGroup { choices: vec![name], source }),
        }
    }
    groups
}

/// The default of a parameter, as the end of a sentence on what is allowed.
fn default_text(param: &ParamInfo) -> String {
    match &param.kind {
        ParamKind::Number { default, .. } if param.is_field => {
            format!("; default {default}; may differ from place to place")
        }
        ParamKind::Number { default, .. } => format!("; default {default}"),
        ParamKind::Choice { choices, default } => format!("; default {}", choices[*default]),
        ParamKind::Text | ParamKind::Path | ParamKind::Table { .. } => String::new(),
    }
}

/// A plugin as JSON.
fn plugin_json(p: &PluginInfo, path: &Path, sources: &[ChoiceSource]) -> Value {
    let params = p.params.iter().enumerate().map(|(index, param)| param_json(index, param, sources));
    json!({
        "kind": p.kind.name(),
        "id": p.id,
        "name": p.name,
        "version": p.version,
        "summary": p.summary,
        "path": path.display().to_string(),
        "real_time": p.real_time,
        "deterministic": p.deterministic,
        "whole_lists": p.whole_lists,
        "params": params.collect::<Vec<_>>(),
    })
}

/// A parameter as JSON.
fn param_json(index: usize, param: &ParamInfo, sources: &[ChoiceSource]) -> Value {
    let mut row = json!({ "key": param.key, "unit": param.unit, "summary": param.summary });
    match &param.kind {
        ParamKind::Number { min, max, default } => {
            row["type"] = "number".into();
            row["min"] = json!(min);
            row["max"] = json!(max);
            row["field"] = json!(param.is_field);
            row["default"] = json!(default);
        }
        ParamKind::Choice { choices, default } => {
            row["type"] = "choice".into();
            row["choices"] = json!(choices);
            let of = sources.iter().filter(|s| s.param == index && s.choice < choices.len());
            let of: BTreeMap<&str, Value> =
                of.map(|s| (&*choices[s.choice], json!({ "source": s.source, "unknown": s.unknown }))).collect();
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
}
