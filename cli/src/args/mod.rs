//! The arguments of the program. What is said of them here is its help.

mod batch;
mod cli;
mod device;
mod edit;
mod plugin;
mod report;
mod run;
mod sample;
mod values;

pub use batch::{BatchArgs, BatchCommand, BatchRunArgs, CollectArgs, EngineArg, PlotArgs, ScriptArgs};
pub use cli::{Cli, Command};
pub use device::{DeviceCommand, DoctorArgs};
pub use edit::EditArgs;
pub use plugin::{CheckArgs, InfoArgs, Language, NewArgs, NewKind, PluginCommand};
pub use report::{AccuracyArgs, ReportCommand, ReportOptionArgs};
pub use run::{PlanArgs, ReplayArgs, RunArgs, SceneArgs};
pub use sample::SampleArgs;
