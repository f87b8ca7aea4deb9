//! Arguments of `pliant device`.

use super::plugin::{AnswerLimit, ListArgs};
use super::values::setting;
use clap::{Args, Subcommand};
use std::path::PathBuf;

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
    List(ListArgs),
    /// Show what devices need, what is missing, and how to get it; exit code 1 if something is missing
    Doctor(DoctorArgs),
    /// Run the program that emulates a device's hardware
    Emulate {
        /// Name of the device
        name: String,
        /// Arguments of the twin
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
    #[command(flatten)]
    pub limit: AnswerLimit,
    /// Library that a child process opens (see `survey.rs`)
    #[arg(long, hide = true, value_name = "FILE", requires = "name")]
    pub child: Option<PathBuf>,
}
