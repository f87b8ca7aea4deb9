//! `pliant device`.

use crate::args::{Cli, DeviceCommand, DoctorArgs};
use crate::outcome::{Failure, Outcome};
use crate::output::{print, print_json};
use crate::search::search_path;
use crate::survey::{Surveyed, answer, ask, survey};
use pliant_host::{Finding, Library, ParamSettings, PluginInfo, PluginKind, SearchPath, probe_device, realtime_rights};
use pliant_plugin_api::abi;
use serde_json::{Value, json};
use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

/// Lists devices, finds out what they lack, or emulates one.
pub fn device(cli: &Cli, command: &DeviceCommand) -> Result<Outcome, Failure> {
    match command {
        DeviceCommand::List(args) if !args.child.is_empty() => {
            answer(&args.child, |library, _| Ok(devices_json(library)))
        }
        DeviceCommand::Doctor(DoctorArgs { name: Some(name), set, child: Some(path), .. }) => {
            answer(std::slice::from_ref(path), |library, _| device_json(library, name, set))
        }
        DeviceCommand::List(_) => list(cli, &search_path(cli)?),
        DeviceCommand::Doctor(args) => doctor(cli, &search_path(cli)?, args),
        DeviceCommand::Emulate { name, args } => emulate(&search_path(cli)?, name, args),
    }
}

/// A device plugin and what its device needs.
struct ProbedDevice {
    /// Id of the plugin.
    id: String,
    name: String,
    summary: String,
    /// Path of its library.
    path: String,
    /// Findings of the plugin; none if it has no probe.
    findings: Vec<Finding>,
}

impl ProbedDevice {
    /// Asks a plugin what its device needs. A plugin that fails is a finding too.
    fn probe(library: &'static Library, info: &'static PluginInfo, settings: &ParamSettings) -> Self {
        let failed = |error: &dyn std::fmt::Display| vec![Finding::missing("plugin", error.to_string(), "")];
        let findings = probe_device(library, &info.id, settings).unwrap_or_else(|error| Some(failed(&error)));
        Self {
            id: info.id.clone(),
            name: info.name.clone(),
            summary: info.summary.clone(),
            path: library.path().display().to_string(),
            findings: findings.unwrap_or_default(),
        }
    }

    /// The first finding that keeps the device from being used.
    fn first_error(&self) -> Option<&Finding> {
        self.findings.iter().find(|f| f.severity >= abi::ERROR)
    }

    /// The device as JSON.
    fn json(&self) -> Value {
        json!({
            "id": self.id, "name": self.name, "summary": self.summary, "path": self.path,
            "usable": self.first_error().is_none(),
            "findings": self.findings.iter().map(finding_json).collect::<Vec<_>>(),
        })
    }

    /// The device of [`ProbedDevice::json`].
    fn from_json(device: &Value) -> Self {
        let [id, name, summary, path] = ["id", "name", "summary", "path"].map(|key| text(device, key));
        let findings = device["findings"].as_array().into_iter().flatten().map(finding_from_json).collect();
        Self { id, name, summary, path, findings }
    }
}

/// The text at a key; empty if there is none.
fn text(value: &Value, key: &str) -> String {
    value[key].as_str().unwrap_or_default().to_owned()
}

/// A finding as JSON.
fn finding_json(f: &Finding) -> Value {
    json!({ "what": f.what, "state": state(f), "found": f.found, "remedy": f.remedy })
}

/// The finding of [`finding_json`].
fn finding_from_json(finding: &Value) -> Finding {
    let severity = match finding["state"].as_str() {
        Some("good") => abi::INFO,
        Some("warning") => abi::WARNING,
        _ => abi::ERROR,
    };
    let [what, found, remedy] = ["what", "found", "remedy"].map(|key| text(finding, key));
    Finding { severity, what, found, remedy }
}

/// The word for the severity of a finding.
fn state(finding: &Finding) -> &'static str {
    match finding.severity {
        abi::INFO => "good",
        abi::WARNING => "warning",
        _ => "missing",
    }
}

/// Every device plugin that is found, and a finding for each library that cannot be opened: it could be the device that is looked for.
fn probe_all(search: &SearchPath) -> Result<(Vec<ProbedDevice>, Vec<Finding>), Failure> {
    let (mut probed, mut unusable) = (Vec::new(), Vec::new());
    for Surveyed { found, answer } in survey(search.scan(), ["device", "list"])? {
        match answer {
            Ok(devices) => probed.extend(devices.as_array().into_iter().flatten().map(ProbedDevice::from_json)),
            Err(error) => unusable.push(Finding::missing(format!("plugin `{}`", found.name), error.text, "")),
        }
    }
    Ok((probed, unusable))
}

/// The devices of a library, with what they need, as JSON.
fn devices_json(library: &'static Library) -> Value {
    let devices = library.plugins().iter().filter(|plugin| plugin.kind == PluginKind::Device);
    devices.map(|info| ProbedDevice::probe(library, info, &ParamSettings::new()).json()).collect()
}

/// `pliant device list`.
fn list(cli: &Cli, search: &SearchPath) -> Result<Outcome, Failure> {
    let (all, unusable) = probe_all(search)?;
    let outcome = if unusable.is_empty() { Outcome::Done } else { Outcome::Plugin };
    if cli.json {
        let rows: Vec<Value> = all.iter().map(ProbedDevice::json).collect();
        let unusable: Vec<Value> = unusable.iter().map(finding_json).collect();
        print_json(&json!({ "devices": rows, "unusable": unusable }))?;
        return Ok(outcome);
    }
    let line = |device: &ProbedDevice| {
        let state =
            device.first_error().map_or("usable".into(), |f| format!("not usable now: {}: {}", f.what, f.found));
        format!("{:<14} {:<48} {state}", device.id, device.summary)
    };
    let mut lines: Vec<String> = all.iter().map(line).collect();
    lines.extend(unusable.iter().map(|finding| format!("{:<14} {}: {}", "unusable", finding.what, finding.found)));
    print(&if lines.is_empty() { "no device plugins found".into() } else { lines.join("\n") })?;
    Ok(outcome)
}

/// `pliant device doctor`.
fn doctor(cli: &Cli, search: &SearchPath, args: &DoctorArgs) -> Result<Outcome, Failure> {
    let (devices, unusable) = match &args.name {
        None => probe_all(search)?,
        Some(name) => (vec![probe_one(search, name, args)?], Vec::new()),
    };
    let mut machine = vec![realtime_rights()];
    machine.extend(unusable);
    let is_missing = |finding: &Finding| finding.severity >= abi::ERROR;
    let outcome = match devices.iter().any(|device| device.first_error().is_some()) || machine.iter().any(is_missing) {
        true => Outcome::CheckFailed,
        false => Outcome::Done,
    };
    if cli.json {
        let rows: Vec<Value> = devices.iter().map(ProbedDevice::json).collect();
        print_json(&json!({ "host": machine.iter().map(finding_json).collect::<Vec<_>>(), "devices": rows }))?;
        return Ok(outcome);
    }
    let mut lines = vec!["this machine".to_owned()];
    lines.extend(machine.iter().flat_map(finding_lines));
    for device in &devices {
        lines.push(format!("{}: {}", device.id, device.summary));
        match &device.findings[..] {
            [] => lines.push("  good     needs nothing".into()),
            findings => lines.extend(findings.iter().flat_map(finding_lines)),
        }
    }
    print(&lines.join("\n"))?;
    Ok(outcome)
}

/// The device plugin of that name, with parameters. A child opens its library and asks it.
fn probe_one(search: &SearchPath, name: &str, args: &DoctorArgs) -> Result<ProbedDevice, Failure> {
    let found = search.find_trusted(name, Path::new("."))?;
    let settings: Vec<String> = args.set.iter().map(|(key, text)| format!("--set={key}={text}")).collect();
    let verb: Vec<&str> = ["device", "doctor", name].into_iter().chain(settings.iter().map(|s| &**s)).collect();
    Ok(ProbedDevice::from_json(&ask(&found, &verb, args.limit.duration())?))
}

/// In a child: the device of that name in a library, or the only one, with parameters, as JSON.
fn device_json(library: &'static Library, name: &str, set: &[(String, String)]) -> Result<Value, Failure> {
    let no_device = || Failure::input(format!("`{name}` is not a device; `pliant device list` names the devices"));
    let by_id = library.plugins().iter().find(|p| p.kind == PluginKind::Device && p.id == *name);
    let info = by_id.or_else(|| library.only_plugin(PluginKind::Device)).ok_or_else(no_device)?;
    let settings = set.iter().map(|(key, text)| info.setting(key, text)).collect::<Result<_, _>>();
    Ok(ProbedDevice::probe(library, info, &settings.map_err(Failure::input)?).json())
}

/// A finding as people read it: what was found, and the remedy if there is one.
fn finding_lines(finding: &Finding) -> Vec<String> {
    let mut lines = vec![format!("  {:<8} {}: {}", state(finding), finding.what, finding.found)];
    if !finding.remedy.is_empty() {
        lines.push(format!("           -> {}", finding.remedy));
    }
    lines
}

/// Runs the twin of a device; on Unix it replaces this process.
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
        if status.success() { Ok(Outcome::Done) } else { Err(Failure::plugin(format!("the twin ended: {status}"))) }
    }
}
