//! The `pliant` command: parses its arguments, calls the engine, prints.
//!
//! Results for machines go to standard output, everything for people to standard error. Exit codes: 0 done, 1 done but a
//! check failed, 2 unusable input or usage, 3 a plugin or device failed, 130 stopped by the user.
//!
//! The crate computes nothing. It has one file for each verb; `args` says what may be typed, `output` is the only place that prints.
//!
//! ```sh
//! pliant run scenes/touch.toml --set body.0.material.params.young="40 kPa"
//! pliant plugin info mass-spring --json
//! ```

#![deny(clippy::wildcard_enum_match_arm)]

mod args;
mod batch;
mod call_watchdog;
mod check;
mod child;
mod device;
mod doctor;
mod edit;
mod escape;
mod isolate;
mod live;
mod new;
mod outcome;
mod output;
mod plan;
mod plugin;
mod replay;
mod report;
mod run;
mod run_end;
mod sample;
mod scene_session;
mod search;
mod stop;
mod survey;

use args::{Cli, Command};
use clap::{CommandFactory, Parser};
use outcome::{Failure, Outcome};
use output::{note, print, print_json};
use pliant_host::{detect_plugin_exit, record_exit_code};
use serde_json::json;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::try_parse().unwrap_or_else(|error| exit_on_misuse(&error));
    let outcome = guarded(&cli);
    record_exit_code(outcome.exit_code());
    outcome.into()
}

/// Runs a command; what ends the program on the way is a failure of a plugin.
fn guarded(cli: &Cli) -> Outcome {
    let _note = PanicNote;
    detect_plugin_exit(if cli.json { report_exit_as_json } else { report_exit });
    isolate::watch_child().and_then(|()| run_command(cli)).unwrap_or_else(|failure| report_failure(&failure, cli.json))
}

/// Exit code of a Rust program that panics.
const PANICKED: u8 = 101;

/// Notes, when it is dropped by a panic, that the program ends by its own fault and not by that of a plugin.
struct PanicNote;

impl Drop for PanicNote {
    fn drop(&mut self) {
        if std::thread::panicking() {
            record_exit_code(PANICKED);
        }
    }
}

/// Says that a plugin ended the program.
fn report_exit(text: &str) {
    report_failure(&Failure::plugin(text), false);
}

/// Says that a plugin ended the program, on standard output as well.
fn report_exit_as_json(text: &str) {
    report_failure(&Failure::plugin(text), true);
}

/// Runs the command that was typed.
fn run_command(cli: &Cli) -> Result<Outcome, Failure> {
    match &cli.command {
        Command::Run(args) => run::run(cli, args),
        Command::Edit(args) => edit::edit(cli, args),
        Command::Doctor => doctor::doctor(cli),
        Command::Batch(args) => batch::batch(cli, args),
        Command::Replay(args) => replay::replay(cli, args),
        Command::Plan(args) => plan::plan(cli, args),
        Command::Plugin(args) => plugin::plugin(cli, &args.command),
        Command::Report(args) => report::report(cli, &args.command),
        Command::Device(args) => device::device(cli, &args.command),
        Command::Schema => schema(),
        Command::Completions { shell } => completions(cli, *shell),
        Command::Sample(args) => sample::sample(cli, args),
    }
}

/// Runs `pliant schema`: prints the JSON Schema of scene files.
fn schema() -> Result<Outcome, Failure> {
    print_json(&pliant_engine::scene::json_schema())?;
    Ok(Outcome::Done)
}

/// Runs `pliant completions`: prints the completion script of a shell.
fn completions(cli: &Cli, shell: clap_complete::Shell) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "pliant", &mut script);
    let script = String::from_utf8_lossy(&script);
    if cli.json {
        print_json(&json!({ "shell": shell.to_string(), "script": script }))?;
    } else {
        print(&script)?;
    }
    Ok(Outcome::Done)
}

/// Prints why a command failed, and gives its outcome. Standard output may be what failed, so errors of printing are ignored.
fn report_failure(failure: &Failure, json: bool) -> Outcome {
    if json {
        let _ = print_json(&json!({ "error": failure.text, "exit_code": failure.outcome.exit_code() }));
    }
    note(&format!("error: {}", failure.text));
    failure.outcome
}

/// Prints what is wrong with the arguments, or the help that was asked for, and ends the program.
fn exit_on_misuse(error: &clap::Error) -> ! {
    if error.use_stderr() && std::env::args_os().any(|argument| argument == "--json") {
        let document = json!({ "error": error.render().to_string(), "exit_code": Outcome::Input.exit_code() });
        let _ = print_json(&document);
    }
    error.exit()
}
