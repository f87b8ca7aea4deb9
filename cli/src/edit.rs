//! `pliant edit`: starts the window, which is a program of its own, so that this one needs no graphics library.

use crate::args::{Cli, EditArgs};
use crate::child::{ChildEnd, run_to_end};
use crate::outcome::{Failure, Outcome};
use clap::ValueEnum;
use std::env::consts::EXE_SUFFIX;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The program of the window, without its ending.
const WINDOW: &str = "pliant-window";

/// Starts the window and waits until it is closed.
pub fn edit(cli: &Cli, args: &EditArgs) -> Result<Outcome, Failure> {
    let program = find_window()?;
    match run_to_end(Command::new(&program).args(window_arguments(cli, args)), None) {
        ChildEnd::Exited { code, .. } => Outcome::from_exit_code(code)
            .ok_or_else(|| Failure::plugin(format!("{}: ended with code {code}", program.display()))),
        end @ (ChildEnd::Signalled { .. } | ChildEnd::TimedOut { .. } | ChildEnd::NotStarted(_)) => {
            Err(Failure::plugin(format!("{}: {end}", program.display())))
        }
    }
}

/// The program of the window: beside this one, or in a folder of `$PATH`.
pub(crate) fn find_window() -> Result<PathBuf, Failure> {
    let name = format!("{WINDOW}{EXE_SUFFIX}");
    let beside = std::env::current_exe().ok().and_then(|own| own.parent().map(Path::to_path_buf));
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = beside.into_iter().chain(std::env::split_paths(&path));
    folders.map(|folder| folder.join(&name)).find(|program| program.is_file()).ok_or_else(|| {
        Failure::input(format!(
            "`{name}`, the program of the window, is neither beside `pliant` nor on the path. \
             Build it with `cargo build --release --manifest-path window/Cargo.toml --target-dir target`"
        ))
    })
}

/// The arguments as the window takes them.
fn window_arguments(cli: &Cli, args: &EditArgs) -> Vec<std::ffi::OsString> {
    let mut list: Vec<std::ffi::OsString> = Vec::new();
    let mut add = |option: &str, value: &dyn AsRef<std::ffi::OsStr>| {
        list.push(option.into());
        list.push(value.as_ref().into());
    };
    for folder in &cli.plugin_path {
        add("--plugin-path", folder);
    }
    for folder in &cli.allow_plugins {
        add("--allow-plugins", folder);
    }
    add("--threads", &args.threads.to_string());
    if let Some(unit) = args.unit.and_then(|unit| unit.to_possible_value()) {
        add("--unit", &unit.get_name());
    }
    if let Some(level) = args.level {
        add("--level", &level.to_string());
    }
    if let Some(device) = &args.device {
        add("--device", device);
    }
    for (key, value) in &args.device_set {
        add("--device-set", &format!("{key}={value}"));
    }
    if let Some(samples) = &args.antialias {
        add("--antialias", samples);
    }
    if let Some(log) = &args.log {
        add("--log", log);
    }
    if let Some(seconds) = args.measure {
        add("--measure", &seconds.to_string());
    }
    if args.timings {
        list.push("--timings".into());
    }
    if args.subdivide {
        list.push("--subdivide".into());
    }
    if args.without_window {
        list.push("--without-window".into());
    }
    list.extend(args.path.iter().map(|path| path.clone().into_os_string()));
    list
}
