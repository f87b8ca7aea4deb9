//! The host's side of the plugin border: where plugins are looked for, how they are opened, and safe calls into them.
//!
//! This folder and `plugin-api` are the only places of the engine with `unsafe`. A library is opened with `RTLD_NOW |
//! RTLD_LOCAL` by absolute path and stays mapped until the program ends: thread-locals, static strings and descriptors
//! point into it.

mod device;
mod elf;
mod error;
mod face;
mod force_model;
mod grid;
mod instance;
mod library;
mod material;
mod normals;
mod plugin;
mod probe;
mod report;
mod rights;
mod search;
mod single;
mod sources;

pub use device::MOST_EFFECTORS;
pub use device::{Device, DeviceInfo, Output, Pose, Stopper};
pub use error::HostError;
pub use grid::{Grid, Region};
pub use instance::Settings;
pub use library::Library;
pub use material::Material;
pub use plugin::{Kind, ParamInfo, ParamKind, ParamValue, PluginInfo};
pub use probe::{Finding, probe};
pub use report::Message;
pub use rights::real_time;
pub use search::{Found, Search};
pub use sources::{ChoiceSource, sources};
