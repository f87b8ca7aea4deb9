//! Arguments of `pliant report`.

use super::values::{duration, setting, thread_count};
use clap::{Args, Subcommand};
use std::path::PathBuf;

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
    #[arg(long, value_name = "FILE", conflicts_with_all = ["catalogue", "print_catalogue"])]
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
    /// Print the program's own catalogue, with what each key means, to begin another from
    #[arg(long, conflicts_with = "catalogue")]
    pub print_catalogue: bool,
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
    /// Longest time of a call of a plugin; then the program is ended, and the plugin and the call are named
    #[arg(long, value_name = "TIME", default_value = "60 s", value_parser = duration)]
    pub call_limit: f64,
    /// Number of threads of a run; 0 uses all processors
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = thread_count)]
    pub threads: usize,
    /// Seed of the order in which timed runs are interleaved
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Print neither progress nor a summary
    #[arg(long, short)]
    pub quiet: bool,
}
