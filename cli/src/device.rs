//! `pliant device`.

use crate::args::{Cli, DeviceCommand, DoctorArgs};
use crate::outcome::{Failure, Outcome};
use crate::text;
use pliant_host::{
    Finding, Library, ParamKind, ParamSettings, ParamValue, PluginInfo, PluginKind, SearchPath, probe_device,
    realtime_rights,
};
use pliant_plugin_api::abi;
use serde_json::{Value, json};
use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

pub fn device(cli: &Cli, what: &DeviceCommand) -> Result<Outcome, Failure> {
    let search = SearchPath::new(&cli.plugin_path);
    match what {
        DeviceCommand::List => list(cli, &search),
        DeviceCommand::Doctor(args) => doctor(cli, &search, args),
        DeviceCommand::Emulate { name, args } => emulate(&search, name, args),
    }
}

/// A device plugin, and what it says it needs; `None` where it does not say.
struct Asked {
    library: &'static Library,
    info: &'static PluginInfo,
    findings: Option<Vec<Finding>>,
}

impl Asked {
    fn ask(library: &'static Library, info: &'static PluginInfo, settings: &ParamSettings) -> Self {
        let failed = |error: &dyn std::fmt::Display| vec![Finding::missing("plugin", error.to_string(), "")];
        let findings = probe_device(library, &info.id, settings).unwrap_or_else(|error| Some(failed(&error)));
        Self { library, info, findings }
    }

    fn lacks(&self) -> Option<&Finding> {
        self.findings.iter().flatten().find(|f| f.severity >= abi::ERROR)
    }

    fn json(&self) -> Value {
        let finding = |f: &Finding| json!({ "what": f.what, "state": state(f), "found": f.found, "remedy": f.remedy });
        json!({
            "id": self.info.id, "name": self.info.name, "summary": self.info.summary, "path": self.library.path(),
            "usable": self.lacks().is_none(),
            "findings": self.findings.iter().flatten().map(finding).collect::<Vec<_>>(),
        })
    }
}

fn state(finding: &Finding) -> &'static str {
    match finding.severity {
        abi::INFO => "good",
        abi::WARNING => "wanting",
        _ => "missing",
    }
}

fn devices(search: &SearchPath) -> Vec<Asked> {
    let libraries = search.scan().into_iter().filter_map(|found| Library::open(&found.path).ok());
    let each = |library: &'static Library| {
        let devices = library.plugins().iter().filter(|p| p.kind == PluginKind::Device);
        devices.map(move |info| Asked::ask(library, info, &ParamSettings::new()))
    };
    libraries.flat_map(each).collect()
}

fn list(cli: &Cli, search: &SearchPath) -> Result<Outcome, Failure> {
    let all = devices(search);
    if cli.json {
        let rows: Vec<Value> = all.iter().map(Asked::json).collect();
        return text::out(&crate::pretty(&json!({ "devices": rows })));
    }
    let line = |asked: &Asked| {
        let state = asked.lacks().map_or("usable".into(), |f| format!("not now: {}: {}", f.what, f.found));
        format!("{:<14} {:<48} {state}", asked.info.id, asked.info.summary)
    };
    let lines: Vec<String> = all.iter().map(line).collect();
    text::out(if lines.is_empty() { "no device plugins found".into() } else { lines.join("\n") }.as_str())
}

/// Exit code 1 where something is missing.
fn doctor(cli: &Cli, search: &SearchPath, args: &DoctorArgs) -> Result<Outcome, Failure> {
    let asked = match &args.name {
        None => devices(search),
        Some(name) => {
            let library = Library::open(&search.find(name, Path::new("."))?.path)?;
            let none = || Failure::input(format!("`{name}` is no device; `pliant device list` names those there are"));
            let known = library.plugins().iter().find(|p| p.kind == PluginKind::Device && p.id == *name);
            let info = known.or_else(|| library.only_plugin(PluginKind::Device)).ok_or_else(none)?;
            let settings =
                args.set.iter().map(|s| setting(info, s)).collect::<Result<_, _>>().map_err(Failure::input)?;
            vec![Asked::ask(library, info, &settings)]
        }
    };
    let host = realtime_rights();
    let outcome = if asked.iter().any(|a| a.lacks().is_some()) { Outcome::CheckFailed } else { Outcome::Done };
    if cli.json {
        let rows: Vec<Value> = asked.iter().map(Asked::json).collect();
        let host = json!([{ "what": host.what, "state": state(&host), "found": host.found, "remedy": host.remedy }]);
        return text::out(&crate::pretty(&json!({ "host": host, "devices": rows }))).map(|_| outcome);
    }
    let mut lines = vec!["this machine".to_owned()];
    tell(&mut lines, &host);
    for asked in &asked {
        lines.push(format!("{}: {}", asked.info.id, asked.info.summary));
        match asked.findings.as_deref() {
            None | Some([]) => lines.push("  good     needs nothing".into()),
            Some(findings) => findings.iter().for_each(|f| tell(&mut lines, f)),
        }
    }
    text::out(&lines.join("\n")).map(|_| outcome)
}

fn tell(lines: &mut Vec<String>, finding: &Finding) {
    lines.push(format!("  {:<8} {}: {}", state(finding), finding.what, finding.found));
    if !finding.remedy.is_empty() {
        lines.push(format!("           -> {}", finding.remedy));
    }
}

fn setting(info: &PluginInfo, (key, text): &(String, String)) -> Result<(usize, ParamValue), String> {
    let known = || info.params.iter().map(|p| p.key.as_str()).collect::<Vec<_>>().join(", ");
    let place = info.params.iter().position(|p| p.key == *key);
    let place = place.ok_or_else(|| format!("`{}` has no parameter `{key}`; allowed is {}", info.id, known()))?;
    let param = &info.params[place];
    let value = match param.kind {
        ParamKind::Number { .. } => text.parse().map(ParamValue::Number).map_err(|_| param.allowed()),
        ParamKind::Table { .. } => Err("nothing here: tables are for scenes".into()),
        _ => Ok(ParamValue::Text(text.clone())),
    };
    let value = value.map_err(|allowed| format!("`{key}` is `{text}`; allowed is {allowed}"))?;
    param.check(&value).map_err(|reason| format!("`{key}`: {reason}"))?;
    Ok((place, value))
}

/// Becomes the stand-in: a process of its own, under this one's number where the system can.
fn emulate(search: &SearchPath, name: &str, args: &[OsString]) -> Result<Outcome, Failure> {
    let program = search.find_twin(name)?;
    let mut command = Command::new(&program);
    command.args(args);
    #[cfg(unix)]
    {
        use std::os::unix::process::CommandExt;
        let error = command.exec();
        Err(Failure::plugin(format!("{}: {error}", program.display())))
    }
    #[cfg(not(unix))]
    {
        let status = command.status().map_err(|e| Failure::plugin(format!("{}: {e}", program.display())))?;
        if status.success() { Ok(Outcome::Done) } else { Err(Failure::plugin(format!("the stand-in ended: {status}"))) }
    }
}
