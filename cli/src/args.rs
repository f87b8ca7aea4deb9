//! What may be typed.

use clap::{Args, Parser, Subcommand, ValueEnum};
use pliant_engine::scene::parse_quantity;
use std::path::PathBuf;

/// Haptic shape editing: touch, pull and cut meshes, feel the force, get the numbers.
#[derive(Parser)]
#[command(name = "pliant", version, about, arg_required_else_help = true, disable_help_subcommand = true)]
pub struct Cli {
    /// One machine-readable document on standard output
    #[arg(long, global = true)]
    pub json: bool,
    /// A folder with plugins, looked in first; may be given more than once
    #[arg(long, global = true, value_name = "DIR")]
    pub plugin_path: Vec<PathBuf>,
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Run a scene's edits and write the deformed model and the numbers
    Run(RunArgs),
    /// Run a recorded session again, with no device there
    Replay(ReplayArgs),
    /// Say what a scene needs, what is left out and why, and how large a step may be
    Plan(SceneArgs),
    /// What plugins there are and what they take
    Plugin(PluginArgs),
    /// Measure error against run time, stability, or cost, and say what misses what it should meet
    Report(ReportArgs),
    /// What devices there are, what they lack, and stand-ins for them
    Device(DeviceArgs),
    /// Print the JSON Schema of scene files
    Schema,
    /// Print a completion script for a shell
    Completions {
        /// Which shell
        shell: clap_complete::Shell,
    },
    /// Write a model to start from
    Sample(SampleArgs),
}

#[derive(Args)]
pub struct SceneArgs {
    /// The scene, a TOML file
    pub scene: PathBuf,
    /// Put another OBJ file in the place of the first body's, scaled to fit
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Put a value in the place of the scene's, for example body.0.material.params.young=2e5
    #[arg(long, value_name = "PATH=VALUE", value_parser = setting)]
    pub set: Vec<(String, String)>,
    /// Threads; 0 takes what the machine has. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

#[derive(Args)]
pub struct RunArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Where results go; by default out/SCENE
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Say nothing while it runs
    #[arg(long, short)]
    pub quiet: bool,
    /// Run in a process of its own: a plugin that crashes ends that one, with exit code 3 and a sentence
    #[arg(long)]
    pub isolate: bool,
    /// Write the session to a file that `pliant replay` runs again
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Keep real time: devices at their own rate, the simulation after the wall clock
    #[arg(long, conflicts_with = "isolate")]
    pub live: bool,
    /// How long, of the wall clock, for example 60 s; by default the scene's duration
    #[arg(long, value_name = "TIME", requires = "live", value_parser = duration)]
    pub duration: Option<f64>,
    /// Rate of the haptic loop; by default that of the fastest device
    #[arg(long, value_name = "HZ", requires = "live", value_parser = rate)]
    pub rate: Option<f64>,
}

#[derive(Args)]
pub struct ReplayArgs {
    /// What `pliant run --record` wrote
    pub recording: PathBuf,
    /// Compare the state after every step with the recorded one; exit code 1 where they differ
    #[arg(long, conflicts_with = "set")]
    pub verify: bool,
    /// Put a value in the place of the recorded scene's: the same hands on another material
    #[arg(long, value_name = "PATH=VALUE", value_parser = setting)]
    pub set: Vec<(String, String)>,
    /// Threads; 0 takes what the machine has. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Where results go; by default out/RECORDING
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Say nothing while it runs
    #[arg(long, short)]
    pub quiet: bool,
}

#[derive(Args)]
pub struct ReportArgs {
    /// Which
    #[arg(value_enum)]
    pub kind: ReportKind,
    /// Only cases whose name contains this; may be given more than once
    #[arg(long, value_name = "NAME")]
    pub case: Vec<String>,
    /// Accuracy or performance of a scene of your own instead
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Another catalogue in the place of the program's own; its scenes are files beside it
    #[arg(long, value_name = "FILE", conflicts_with = "scene")]
    pub catalogue: Option<PathBuf>,
    /// With --scene: put a value in the place of the scene's
    #[arg(long, value_name = "PATH=VALUE", value_parser = setting, requires = "scene")]
    pub set: Vec<(String, String)>,
    /// Fewer resolutions: under a minute
    #[arg(long)]
    pub quick: bool,
    /// Where results go; by default out/report-KIND
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// A report.json of before: what got worse is named, and the exit code is 1
    #[arg(long, value_name = "FILE")]
    pub baseline: Option<PathBuf>,
    /// How much worse counts, as a share
    #[arg(long, value_name = "SHARE", default_value_t = 0.1)]
    pub margin: f64,
    /// Exit with 1 when a result misses what it must meet
    #[arg(long)]
    pub strict: bool,
    /// Begin anew, whatever a report that was stopped left behind
    #[arg(long)]
    pub fresh: bool,
    /// Print the tables as Markdown
    #[arg(long, conflicts_with = "json")]
    pub markdown: bool,
    /// Threads of a run; 0 takes what the machine has
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub threads: usize,
    /// Of the order in which timed runs are interleaved
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Say nothing while it runs
    #[arg(long, short)]
    pub quiet: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ReportKind {
    /// Error against run time, of known answers
    Accuracy,
    /// What holds, up to where, and what happens beyond
    Stability,
    /// What a step costs
    Performance,
}

#[derive(Args)]
pub struct PluginArgs {
    #[command(subcommand)]
    pub what: PluginCommand,
}

#[derive(Subcommand)]
pub enum PluginCommand {
    /// List every plugin that is found, and where
    List,
    /// Show a plugin's parameters with their units, ranges and defaults
    Info {
        /// Its name, or a path to its library
        name: String,
    },
    /// Write a project to start a plugin from, with its tests, a README and a scene
    New(NewArgs),
    /// Hold a library against the conformance suite: one process and one sentence a case
    Check(CheckArgs),
}

#[derive(Args)]
pub struct NewArgs {
    /// Its name: lower-case letters, digits and dashes
    pub name: String,
    /// What it is
    #[arg(long, value_enum)]
    pub kind: NewKind,
    /// What it is written in
    #[arg(long, value_enum, default_value_t = Language::Rust)]
    pub lang: Language,
    /// Where the project goes; by default a folder NAME here
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// For Rust: pliant's own source, with plugin-api/ in it; by default what this program was built from
    #[arg(long, value_name = "DIR")]
    pub pliant: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum NewKind {
    /// What the force is
    Material,
    /// Which nodes carry a surface
    Grid,
    /// Where the hand is
    Device,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Language {
    /// One trait; built by cargo
    Rust,
    /// C11 with a Makefile
    C,
    /// C++17 with a Makefile
    Cpp,
}

#[derive(Args)]
pub struct CheckArgs {
    /// A library, or the name of one that is found
    pub file: PathBuf,
    /// Only the plugin with this id
    #[arg(long)]
    pub id: Option<String>,
    /// Only this case
    #[arg(long)]
    pub case: Option<String>,
    /// Seconds a case may take
    #[arg(long, default_value_t = 20.0)]
    pub seconds: f64,
    /// In a child: what it does
    #[arg(long, hide = true)]
    pub child: Option<String>,
}

#[derive(Args)]
pub struct DeviceArgs {
    #[command(subcommand)]
    pub what: DeviceCommand,
}

#[derive(Subcommand)]
pub enum DeviceCommand {
    /// List every device plugin, and whether its device can be used now
    List,
    /// Say what devices need, what is missing, and how to get it
    Doctor(DoctorArgs),
    /// Run a stand-in for a device's hardware, a program of its own: `pliant device emulate exoskeleton -- --help`
    Emulate {
        /// Which device
        name: String,
        /// For the stand-in
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        args: Vec<std::ffi::OsString>,
    },
}

#[derive(Args)]
pub struct DoctorArgs {
    /// Its name, or a path to its library; all that are found when not given
    pub name: Option<String>,
    /// A parameter as in a scene, for example peer=127.0.0.1:5000
    #[arg(long, value_name = "KEY=VALUE", value_parser = setting, requires = "name")]
    pub set: Vec<(String, String)>,
}

#[derive(Args)]
pub struct SampleArgs {
    /// Which model
    #[arg(default_value = pliant_mesh::sample::NAMES[0], value_parser = pliant_mesh::sample::NAMES.to_vec())]
    pub name: String,
    /// Where to write it; by default NAME.obj
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// How finely it is made: each step quarters its faces
    #[arg(long, default_value_t = pliant_mesh::sample::DEFAULT_DETAIL)]
    pub detail: u32,
    /// Write over files that are there
    #[arg(long)]
    pub force: bool,
}

fn duration(text: &str) -> Result<f64, String> {
    parse_quantity(text, "s").and_then(|t| if t > 0.0 { Ok(t) } else { Err("allowed is a time above 0".into()) })
}

fn rate(text: &str) -> Result<f64, String> {
    let allowed = |rate: &f64| (100.0..=4000.0).contains(rate);
    parse_quantity(text, "Hz").and_then(|r| Some(r).filter(allowed).ok_or("allowed is 100 Hz to 4 kHz".into()))
}

fn setting(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((path, value)) if !path.trim().is_empty() => Ok((path.trim().to_owned(), value.trim().to_owned())),
        _ => Err("allowed is PATH=VALUE, for example time.dt=2ms".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_arguments_make_sense() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_setting_is_a_path_and_a_value() {
        assert_eq!(setting("time.dt = 2e-3"), Ok(("time.dt".into(), "2e-3".into())));
        assert_eq!(setting("title=a=b"), Ok(("title".into(), "a=b".into())));
        assert!(setting("time.dt").is_err() && setting("=3").is_err());
    }
}
