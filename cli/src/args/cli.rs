//! The verbs of the program.

use super::batch::BatchArgs;
use super::device::DeviceArgs;
use super::edit::EditArgs;
use super::plugin::PluginArgs;
use super::report::ReportArgs;
use super::run::{PlanArgs, ReplayArgs, RunArgs};
use super::sample::SampleArgs;
use clap::{Parser, Subcommand};
use std::path::PathBuf;

/// Haptic shape editing: touch, pull and cut meshes, feel the force, get the numbers.
#[derive(Parser)]
#[command(name = "pliant", version, arg_required_else_help = true, disable_help_subcommand = true)]
#[command(after_help = "\
Examples:
  pliant sample elephant -o elephant.obj   a model to start from
  pliant edit elephant.obj                 open it in a window and sculpt it
  pliant run scenes/touch.toml             run a scene; results are in out/touch
  pliant plan scenes/touch.toml            what the scene needs, and how large a step may be
  pliant plugin list                       the plugins that are found

`pliant VERB --help` has the options of a verb. Exit codes: 0 done, 1 a check failed, 2 unusable input or usage,
3 a plugin or device failed, 130 stopped.")]
pub struct Cli {
    /// Print one JSON document on standard output
    #[arg(long, global = true, help_heading = "Global options")]
    pub json: bool,
    /// Folder with plugins that is searched first; may be given more than once
    #[arg(long, global = true, help_heading = "Global options", value_name = "DIR")]
    pub plugin_path: Vec<PathBuf>,
    /// Folder from which scenes and recordings may name libraries by path, which runs their code; may be given more than once
    #[arg(long, global = true, help_heading = "Global options", value_name = "DIR")]
    pub allow_plugins: Vec<PathBuf>,
    #[command(subcommand)]
    pub command: Command,
}

/// The commands of the program, one for each verb of the command line.
#[derive(Subcommand)]
pub enum Command {
    /// Run the edits of a scene and write the deformed model and the numbers
    Run(RunArgs),
    /// Open a window and sculpt a model, or the bodies of a scene, with the mouse
    Edit(EditArgs),
    /// Say which renderer the window gets on this machine, or what it lacks
    Doctor,
    /// Run many scripted edits of scenes, on one machine or a cluster, into one table
    Batch(BatchArgs),
    /// Run a recorded session again, without its devices
    Replay(ReplayArgs),
    /// Show what a scene needs, what is left out and why, and how large a step may be
    Plan(PlanArgs),
    /// List plugins, show their parameters, begin and check your own
    Plugin(PluginArgs),
    /// Measure error against run time, stability, or cost; mark results that miss their criterion
    Report(ReportArgs),
    /// List devices, find out what they lack, and emulate them
    Device(DeviceArgs),
    /// Print the JSON Schema of scene files
    Schema,
    /// Print a completion script for a shell
    Completions {
        /// Name of the shell
        shell: clap_complete::Shell,
    },
    /// Write a model to start from
    Sample(SampleArgs),
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn only_the_report_that_takes_a_scene_offers_it() {
        let mut command = Cli::command();
        command.build();
        let report = command.find_subcommand_mut("report").unwrap();
        for (kind, offers) in [("accuracy", true), ("stability", false), ("performance", false)] {
            let help = report.find_subcommand_mut(kind).unwrap().render_long_help().to_string();
            assert_eq!(help.contains("--scene"), offers, "{kind}");
        }
    }
}
