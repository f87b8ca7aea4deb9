//! Arguments of `pliant batch`.

use super::values::{memory, thread_count};
use clap::{Args, Subcommand, ValueEnum};
use pliant_batch::Shard;
use pliant_engine::memory::MemoryBudget;
use std::path::PathBuf;

/// Arguments of `pliant batch`.
#[derive(Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(after_help = "\
Examples:
  pliant batch sweep.toml --dry-run                     how many runs, how long, how large
  pliant batch sweep.toml --out out/sweep               all of them; the table is out/sweep/results.csv
  pliant batch sweep.toml --out out/sweep --resume      what is missing
  pliant batch sweep.toml --out out/sweep --shard 3/8   the third of eight parts
  pliant batch status out/sweep
  pliant batch collect out/sweep --output results.csv
  pliant batch plot out/sweep young largest_force --by radius --output force.svg
  pliant batch script sweep.toml --engine slurm --shards 8 > sweep.sh")]
pub struct BatchArgs {
    #[command(subcommand)]
    pub command: Option<BatchCommand>,
    #[command(flatten)]
    pub run: BatchRunArgs,
}

/// Arguments of running a sweep.
#[derive(Args)]
pub struct BatchRunArgs {
    /// TOML file of the sweep
    #[arg(required = true)]
    pub sweep: Option<PathBuf>,
    /// Folder of the results [default: out/SWEEP]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Do only part I of N; parts may run on different machines
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    pub shard: Shard,
    /// Number of runs at a time, at most that of the processors and what fits into memory; 0 uses all processors. Results do not depend on it
    #[arg(long, value_name = "J", default_value_t = 0, value_parser = thread_count)]
    pub jobs: usize,
    /// Execute as many runs at a time as --jobs asks for, however many processors and how much memory there are
    #[arg(long)]
    pub oversubscribe: bool,
    /// Largest memory of all concurrent runs, such as "4 GB"; others wait, and a run that is estimated to need more fails [default: three quarters of the machine's]
    #[arg(long, value_name = "SIZE", value_parser = memory)]
    pub memory: Option<MemoryBudget>,
    /// Do what is missing in the folder; rows whose scene, meshes, plugins or program version have changed are done again
    #[arg(long)]
    pub resume: bool,
    /// With --resume: repeat failed runs as well
    #[arg(long, requires = "resume")]
    pub retry_failed: bool,
    /// Execute runs in child processes, so that a plugin that crashes ends only its own; a limit of memory does the same
    #[arg(long)]
    pub isolate: bool,
    /// Say how many runs there are, how long they take and how large the results are, and execute none
    #[arg(long)]
    pub dry_run: bool,
    /// Print neither progress nor a summary
    #[arg(long, short)]
    pub quiet: bool,
    /// In a child process: execute the runs that standard input names
    #[arg(long, hide = true)]
    pub child: bool,
}

/// What can be done with the results of a batch.
#[derive(Subcommand)]
pub enum BatchCommand {
    /// Merge the shards in folders to one table
    Collect(CollectArgs),
    /// Show how far the shards in folders are
    Status {
        /// Folders of results
        #[arg(required = true, value_name = "DIR")]
        folders: Vec<PathBuf>,
    },
    /// Draw a column of the table over another as SVG
    Plot(PlotArgs),
    /// Print a script that has an engine run the shards of a sweep
    Script(ScriptArgs),
}

/// Arguments of `pliant batch collect`.
#[derive(Args)]
pub struct CollectArgs {
    /// Folders of results
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Table to write, .csv, .jsonl or .parquet [default: results.csv in the first folder]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Take shards of different program versions together, with a column that says which
    #[arg(long)]
    pub mixed: bool,
    /// Add columns of attempts and wall-clock times, which differ from run to run
    #[arg(long)]
    pub timings: bool,
}

/// Arguments of `pliant batch plot`.
#[derive(Args)]
pub struct PlotArgs {
    /// Folder of results
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Column along the horizontal axis
    pub x: String,
    /// Column that is drawn
    pub y: String,
    /// Column whose values have a line each
    #[arg(long, value_name = "COLUMN")]
    pub by: Option<String>,
    /// Draw Y as colour over X and the column of --by
    #[arg(long, requires = "by")]
    pub heat: bool,
    /// SVG file to write [default: Y-over-X.svg in the folder]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Arguments of `pliant batch script`.
#[derive(Args)]
pub struct ScriptArgs {
    /// TOML file of the sweep
    pub sweep: PathBuf,
    /// What runs the shards
    #[arg(long, value_enum)]
    pub engine: EngineArg,
    /// Number of shards
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub shards: u64,
    /// Number of runs at a time in each shard
    #[arg(long, value_name = "J", default_value_t = 1, value_parser = thread_count)]
    pub jobs: usize,
    /// Folder of the results, which all machines share [default: out/SWEEP]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Program as the machines find it [default: this one]
    #[arg(long, value_name = "FILE")]
    pub program: Option<PathBuf>,
}

/// Schedulers and workflow engines for which `batch script` writes a launcher.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EngineArg {
    /// A Slurm job array
    Slurm,
    /// A HyperQueue task array
    Hyperqueue,
    /// Tasks of Dask, in Python
    Dask,
    /// GNU parallel
    Parallel,
    /// A Snakefile
    Snakemake,
}
