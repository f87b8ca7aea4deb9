//! Arguments of `pliant plugin`.

use super::values::case_seconds;
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

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
    List(ListArgs),
    /// Show the parameters of a plugin with units, ranges and defaults
    Info(InfoArgs),
    /// Write a project to begin a plugin from, with tests, a README and a scene
    New(NewArgs),
    /// Run the conformance suite on a library: a process and a line for each case
    Check(CheckArgs),
}

/// Arguments of `pliant plugin list` and `pliant device list`.
#[derive(Args)]
pub struct ListArgs {
    /// Libraries that a child process opens (see `survey.rs`)
    #[arg(long, hide = true, num_args = 1.., value_name = "FILE")]
    pub child: Vec<PathBuf>,
}

/// Arguments of `pliant plugin info`.
#[derive(Args)]
pub struct InfoArgs {
    /// Name of the plugin, or path of its library
    pub name: String,
    #[command(flatten)]
    pub limit: AnswerLimit,
    /// Library that a child process opens (see `survey.rs`)
    #[arg(long, hide = true, value_name = "FILE")]
    pub child: Option<PathBuf>,
}

/// The time that the child process which opens a library has for its answer.
#[derive(Args)]
pub struct AnswerLimit {
    /// Seconds that the library may take to be opened and to answer
    #[arg(long, default_value_t = 20.0)]
    seconds: f64,
}

impl AnswerLimit {
    /// The time, from 0.1 s to 1e6 s.
    pub fn duration(&self) -> Duration {
        Duration::from_secs_f64(self.seconds.clamp(0.1, 1e6))
    }
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
    /// Gives tractions between tools and bodies
    ContactLaw,
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
    /// Seconds that a case may take, 0.1 to 1000000
    #[arg(long, default_value_t = 20.0, value_parser = case_seconds)]
    pub seconds: f64,
    /// Work of a child process that `plugin check` starts (see `check.rs`)
    #[arg(long, hide = true)]
    pub child: Option<String>,
}
