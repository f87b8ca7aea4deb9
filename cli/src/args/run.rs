//! Arguments of `pliant plan`, `pliant run` and `pliant replay`.

use super::values::{duration, memory, rate, setting, thread_count};
use clap::Args;
use pliant_engine::memory::MemoryBudget;
use std::path::{Path, PathBuf};

/// Arguments of `pliant plan`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  pliant plan scenes/touch.toml
  pliant plan scenes/touch.toml --mesh my-model.obj --json")]
pub struct PlanArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Longest time of a call of a plugin; then the program is ended, and the plugin and the call are named
    #[arg(long, value_name = "TIME", default_value = "60 s", value_parser = duration)]
    pub call_limit: f64,
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
    /// Number of threads, at most that of the processors; 0 uses all. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = thread_count)]
    pub threads: usize,
    /// Start as many threads as asked for, also on fewer processors: slow, for tests of results across numbers of threads
    #[arg(long)]
    pub oversubscribe: bool,
    /// Largest memory of the session, such as "4 GB"; a scene that is estimated to need more is refused [default: three quarters of the machine's]
    #[arg(long, value_name = "SIZE", value_parser = memory)]
    pub memory: Option<MemoryBudget>,
    /// Take warnings as errors: exit code 2
    #[arg(long)]
    pub strict: bool,
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
    /// Print neither progress nor a summary, only what fails
    #[arg(long, short)]
    pub quiet: bool,
    /// Run in a child process: a plugin that crashes, hangs or exits ends the child, and this program ends with exit code 3
    #[arg(long)]
    pub isolate: bool,
    /// With --isolate: longest time of a call of a plugin; then the run is ended, and the plugin and the call are named
    #[arg(long, value_name = "TIME", requires = "isolate", default_value = "60 s", value_parser = duration)]
    pub call_limit: f64,
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
    /// Number of threads, at most that of the processors; 0 uses all. Results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = thread_count)]
    pub threads: usize,
    /// Start as many threads as asked for, also on fewer processors: slow, for tests of results across numbers of threads
    #[arg(long)]
    pub oversubscribe: bool,
    /// Largest memory of the session, such as "4 GB"; a scene that is estimated to need more is refused [default: three quarters of the machine's]
    #[arg(long, value_name = "SIZE", value_parser = memory)]
    pub memory: Option<MemoryBudget>,
    /// Folder of the results [default: out/RECORDING.replay]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print neither progress nor a summary, only what fails
    #[arg(long, short)]
    pub quiet: bool,
}
