//! The `pliant` command: parse, call the engine, print.
//!
//! Results for machines go to standard output, everything for people to standard error. Exit codes: 0 done, 1 done but a
//! check failed, 2 unusable input or usage, 3 a plugin or device failed, 130 stopped by the user.

mod args;
mod check;
mod child;
mod device;
mod live;
mod new;
mod open;
mod outcome;
mod plan;
mod plugin;
mod replay;
mod report;
mod run;
mod sample;
mod text;

use args::{Cli, Command};
use clap::{CommandFactory, Parser};
use outcome::Outcome;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::try_parse().unwrap_or_else(|error| outcome::misused(&error));
    let outcome = match &cli.command {
        Command::Run(args) => run::run(&cli, args),
        Command::Replay(args) => replay::replay(&cli, args),
        Command::Plan(args) => plan::plan(&cli, args),
        Command::Plugin(args) => plugin::plugin(&cli, &args.what),
        Command::Report(args) => report::report(&cli, args),
        Command::Device(args) => device::device(&cli, &args.what),
        Command::Schema => text::out(&pretty(&pliant_engine::scene::json_schema())),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "pliant", &mut script);
            let script = String::from_utf8_lossy(&script);
            let document = || pretty(&serde_json::json!({ "shell": shell.to_string(), "script": script }));
            text::out(&if cli.json { document() } else { script.to_string() })
        }
        Command::Sample(args) => sample::sample(&cli, args),
    };
    outcome.unwrap_or_else(|failure| failure.report(cli.json)).into()
}

fn pretty(value: &impl serde::Serialize) -> String {
    serde_json::to_string_pretty(value).unwrap_or_default()
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        Self::from(outcome as u8)
    }
}
