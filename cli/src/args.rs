//! The arguments of the program. What is said of them here is its help.

use clap::{Args, Parser, Subcommand, ValueEnum};
use pliant_engine::scene::parse_quantity;
use std::path::{Path, PathBuf};

/// Haptic shape editing: touch, pull and cut meshes, feel the force, get the numbers.
#[derive(Parser)]
#[command(name = "pliant", version, about, arg_required_else_help = true, disable_help_subcommand = true)]
#[command(after_help = "\
Examples:
  pliant sample elephant -o elephant.obj   a model to start from
  pliant run scenes/touch.toml             run a scene; results are in out/touch
  pliant plan scenes/touch.toml            what the scene needs, and how large a step may be
  pliant plugin list                       the plugins that are found

`pliant VERB --help` has the options of a verb. Exit codes: 0 done, 1 a check failed, 2 unusable input or usage,
3 a plugin or device failed, 130 stopped.")]
pub struct Cli {
    /// Print one JSON document on standard output
    #[arg(long, global = true)]
    pub json: bool,
    /// Folder with plugins that is searched first; may be given more than once
    #[arg(long, global = true, value_name = "DIR")]
    pub plugin_path: Vec<PathBuf>,
    #[command(subcommand)]
    pub command: Command,
}

/// The verbs.
#[derive(Subcommand)]
pub enum Command {
    /// Run the edits of a scene and write the deformed model and the numbers
    Run(RunArgs),
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

/// Arguments of `pliant plan`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  pliant plan scenes/touch.toml
  pliant plan scenes/touch.toml --mesh my-model.obj --json")]
pub struct PlanArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
}

/// A scene and what is changed in it.
#[derive(Args)]
pub struct SceneArgs {
    /// TOML file of the scene
    pub scene: PathBuf,
    /// OBJ file that takes the place of the first body's model, scaled to its size
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Value that takes the place of the scene's, for example body.0.material.params.young=2e5; may be given more than once
    #[arg(long, value_name = "PATH=VALUE", value_parser = setting)]
    pub set: Vec<(String, String)>,
    /// Number of threads; 0 uses all processors. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// Arguments of `pliant run`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  pliant run scenes/touch.toml
  pliant run scenes/touch.toml --mesh my-model.obj --out out/mine
  pliant run scenes/touch.toml --set body.0.material.params.young=\"40 kPa\"
  pliant run scenes/touch.toml --live --duration \"60 s\" --record hand.rec")]
pub struct RunArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Folder of the results [default: out/SCENE]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print neither progress nor a summary
    #[arg(long, short)]
    pub quiet: bool,
    /// Run in a child process: a plugin that crashes ends the child, and this program ends with exit code 3
    #[arg(long)]
    pub isolate: bool,
    /// Record the session into a file that `pliant replay` runs again
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Run in real time: each device at its own rate, the simulation after the wall clock
    #[arg(long, conflicts_with = "isolate")]
    pub live: bool,
    /// Wall-clock duration, for example 60 s [default: the scene's duration]
    #[arg(long, value_name = "TIME", requires = "live", value_parser = duration)]
    pub duration: Option<f64>,
    /// Rate of the haptic loop, 100 Hz to 4 kHz [default: that of the fastest device]
    #[arg(long, value_name = "HZ", requires = "live", value_parser = rate)]
    pub rate: Option<f64>,
}

impl RunArgs {
    /// The folder of the results.
    pub fn out_folder(&self) -> PathBuf {
        let default = || Path::new("out").join(self.scene.scene.file_stem().unwrap_or_default());
        self.out.clone().unwrap_or_else(default)
    }
}

/// Arguments of `pliant replay`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  pliant replay hand.rec --verify
  pliant replay hand.rec --set body.0.material.params.young=\"80 kPa\"")]
pub struct ReplayArgs {
    /// File that `pliant run --record` wrote
    pub recording: PathBuf,
    /// Compare the state after every step with the recorded one; exit code 1 where they differ
    #[arg(long, conflicts_with = "set")]
    pub verify: bool,
    /// Value that takes the place of the recorded scene's: the same hands on another material
    #[arg(long, value_name = "PATH=VALUE", value_parser = setting)]
    pub set: Vec<(String, String)>,
    /// Number of threads; 0 uses all processors. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Folder of the results [default: out/RECORDING.replay]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print neither progress nor a summary
    #[arg(long, short)]
    pub quiet: bool,
}

/// Arguments of `pliant report`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  pliant report accuracy --quick
  pliant report accuracy --scene my-scene.toml
  pliant report stability --case limit
  pliant report performance --quick --baseline old/report.json --margin 0.2")]
pub struct ReportArgs {
    #[command(subcommand)]
    pub command: ReportCommand,
}

/// The kinds of reports.
#[derive(Subcommand)]
pub enum ReportCommand {
    /// Error against run time, of cases with known answers or of a scene of your own
    Accuracy(AccuracyArgs),
    /// Step limits, energy balances, extreme values, and the coupling of a hand
    Stability(ReportOptionArgs),
    /// Time of a step against size, threads and contacts
    Performance(ReportOptionArgs),
}

/// Arguments of `pliant report accuracy`.
#[derive(Args)]
pub struct AccuracyArgs {
    /// Compare this scene with its own refined solution instead of running the catalogue
    #[arg(long, value_name = "FILE", conflicts_with = "catalogue")]
    pub scene: Option<PathBuf>,
    /// With --scene: value that takes the place of the scene's
    #[arg(long, value_name = "PATH=VALUE", value_parser = setting, requires = "scene")]
    pub set: Vec<(String, String)>,
    #[command(flatten)]
    pub options: ReportOptionArgs,
}

/// Options of every report.
#[derive(Args)]
pub struct ReportOptionArgs {
    /// Run only cases whose name contains this; may be given more than once
    #[arg(long, value_name = "NAME")]
    pub case: Vec<String>,
    /// Run this catalogue instead of the program's own; its scenes are files beside it
    #[arg(long, value_name = "FILE")]
    pub catalogue: Option<PathBuf>,
    /// Run fewer resolutions: about a minute
    #[arg(long)]
    pub quick: bool,
    /// Folder of the results [default: out/report-KIND]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Older report.json to compare with: what got worse is listed, and the exit code is then 1
    #[arg(long, value_name = "FILE")]
    pub baseline: Option<PathBuf>,
    /// With --baseline: how much worse counts, as a share
    #[arg(long, value_name = "SHARE", default_value_t = 0.1)]
    pub margin: f64,
    /// End with exit code 1 if a result misses its criterion
    #[arg(long)]
    pub strict: bool,
    /// Begin anew instead of resuming a report that was stopped
    #[arg(long)]
    pub fresh: bool,
    /// Print the tables as Markdown
    #[arg(long, conflicts_with = "json")]
    pub markdown: bool,
    /// Number of threads of a run; 0 uses all processors
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub threads: usize,
    /// Seed of the order in which timed runs are interleaved
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Print neither progress nor a summary
    #[arg(long, short)]
    pub quiet: bool,
}

/// Arguments of `pliant plugin`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  pliant plugin list
  pliant plugin info mass-spring
  pliant plugin new springy --kind material
  pliant plugin check ./libspringy.so")]
pub struct PluginArgs {
    #[command(subcommand)]
    pub command: PluginCommand,
}

/// What can be done with plugins.
#[derive(Subcommand)]
pub enum PluginCommand {
    /// List the plugins that are found, with their files
    List,
    /// Show the parameters of a plugin with units, ranges and defaults
    Info {
        /// Name of the plugin, or path of its library
        name: String,
    },
    /// Write a project to begin a plugin from, with tests, a README and a scene
    New(NewArgs),
    /// Run the conformance suite on a library: a process and a line for each case
    Check(CheckArgs),
}

/// Arguments of `pliant plugin new`.
#[derive(Args)]
pub struct NewArgs {
    /// Name of the plugin: lower-case letters, digits and dashes
    pub name: String,
    /// Kind of plugin
    #[arg(long, value_enum)]
    pub kind: NewKind,
    /// Language of the plugin
    #[arg(long, value_enum, default_value_t = Language::Rust)]
    pub lang: Language,
    /// Folder of the project [default: NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// For Rust: folder of pliant's source, with plugin-api/ in it [default: what this program was built from]
    #[arg(long, value_name = "DIR")]
    pub pliant: Option<PathBuf>,
}

/// The kinds of plugins.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum NewKind {
    /// Gives energies and forces
    Material,
    /// Gives the cells and nodes that carry a surface
    Grid,
    /// Gives poses of hands and renders forces
    Device,
}

/// The languages of plugins.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Language {
    /// One trait; built by cargo
    Rust,
    /// C11 with a Makefile
    C,
    /// C++17 with a Makefile
    Cpp,
}

/// Arguments of `pliant plugin check`.
#[derive(Args)]
pub struct CheckArgs {
    /// Library, or the name of one that is found
    pub file: PathBuf,
    /// Check only the plugin with this id
    #[arg(long)]
    pub id: Option<String>,
    /// Run only this case
    #[arg(long)]
    pub case: Option<String>,
    /// Seconds that a case may take
    #[arg(long, default_value_t = 20.0)]
    pub seconds: f64,
    /// In a child process: what to do, see `check.rs`
    #[arg(long, hide = true)]
    pub child: Option<String>,
}

/// Arguments of `pliant device`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  pliant device list
  pliant device doctor exoskeleton --set peer=192.168.1.20:48620
  pliant device emulate exoskeleton -- --help")]
pub struct DeviceArgs {
    #[command(subcommand)]
    pub command: DeviceCommand,
}

/// What can be done with devices.
#[derive(Subcommand)]
pub enum DeviceCommand {
    /// List the device plugins, and whether their devices can be used now
    List,
    /// Show what devices need, what is missing, and how to get it; exit code 1 if something is missing
    Doctor(DoctorArgs),
    /// Run the program that emulates a device's hardware
    Emulate {
        /// Name of the device
        name: String,
        /// Arguments of the emulator
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        args: Vec<std::ffi::OsString>,
    },
}

/// Arguments of `pliant device doctor`.
#[derive(Args)]
pub struct DoctorArgs {
    /// Name of the device, or path of its library [default: all that are found]
    pub name: Option<String>,
    /// Parameter as in a scene, for example peer=127.0.0.1:5000
    #[arg(long, value_name = "KEY=VALUE", value_parser = setting, requires = "name")]
    pub set: Vec<(String, String)>,
}

/// Arguments of `pliant sample`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  pliant sample elephant -o elephant.obj
  pliant sample elephant --detail 5 --force")]
pub struct SampleArgs {
    /// Name of the model
    #[arg(default_value = pliant_mesh::sample::NAMES[0], value_parser = pliant_mesh::sample::NAMES.to_vec())]
    pub name: String,
    /// OBJ file to write [default: NAME.obj]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Subdivisions: each quarters the faces
    #[arg(long, default_value_t = pliant_mesh::sample::DEFAULT_DETAIL)]
    pub detail: u32,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}

/// A time above zero, s.
fn duration(text: &str) -> Result<f64, String> {
    parse_quantity(text, "s").and_then(|t| if t > 0.0 { Ok(t) } else { Err("allowed is a time above 0".into()) })
}

/// A rate of the haptic loop, Hz.
fn rate(text: &str) -> Result<f64, String> {
    let allowed = |rate: &f64| (100.0..=4000.0).contains(rate);
    parse_quantity(text, "Hz").and_then(|r| Some(r).filter(allowed).ok_or("allowed is 100 Hz to 4 kHz".into()))
}

/// A path and a value.
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
    fn the_arguments_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_setting_is_a_path_and_a_value() {
        assert_eq!(setting("time.dt = 2e-3"), Ok(("time.dt".into(), "2e-3".into())));
        assert_eq!(setting("title=a=b"), Ok(("title".into(), "a=b".into())));
        assert!(setting("time.dt").is_err() && setting("=3").is_err());
    }

    #[test]
    fn only_the_report_that_takes_a_scene_offers_it() {
        let mut command = Cli::command();
        let report = command.find_subcommand_mut("report").unwrap();
        for (kind, offers) in [("accuracy", true), ("stability", false), ("performance", false)] {
            let help = report.find_subcommand_mut(kind).unwrap().render_long_help().to_string();
            assert_eq!(help.contains("--scene"), offers, "{kind}");
        }
    }
}
