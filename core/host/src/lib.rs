//! The host's side of the plugin interface: where plugins are looked for, how they are opened, and safe calls into them.
//!
//! A [`SearchPath`] turns a name into the file of a [`Library`]; a library lists its plugins ([`PluginInfo`]) without running them. An
//! active plugin is a [`Grid`], a [`Material`] or a [`Device`]. A material is a force model of the solver. What a plugin does wrong is a
//! [`HostError`] that names its file and the call.
//!
//! This crate knows no scenes, meshes or bodies, and names no plugin. It and `plugin-api` are the only places of the engine with
//! `unsafe`. A library is opened by absolute path, all symbols bound at once (`RTLD_NOW | RTLD_LOCAL`), and stays mapped until the
//! program ends: thread-locals, static strings and descriptors point into it. Opening a library runs its code, so what a scene may name by
//! path is for the caller to allow ([`AllowedFolders`]); by default nothing is.
//!
//! # Example
//! The parameters that a material takes:
//! ```no_run
//! use pliant_host::{Library, PluginKind, SearchPath};
//! use std::path::Path;
//!
//! # fn main() -> Result<(), pliant_host::HostError> {
//! let found = SearchPath::new(&[]).find("mass-spring", Path::new("."))?;
//! let library = Library::open(&found.path)?;
//! for param in &library.plugin(PluginKind::Material, "mass-spring")?.params {
//!     println!("{}: {}, {}", param.key, param.summary, param.allowed());
//! }
//! # Ok(())
//! # }
//! ```

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod call_board;
mod calls;
mod choice_sources;
mod device;
mod elf;
mod error;
mod f32_tangent;
mod force_model;
mod grid;
mod host_table;
mod instance;
mod library;
mod material;
mod messages;
mod normals;
mod plugin_info;
mod probe;
mod process_end;
mod realtime_rights;
mod search_path;
mod trust;

pub use call_board::{CallBoard, share_calls};
pub use calls::{PluginCall, plugin_calls};
pub use choice_sources::{ChoiceSource, choice_sources};
pub use device::{Device, DeviceInfo, EffectorOutput, MAX_EFFECTORS, POSE_VALID, Pose, StopHandle, check_device_info};
pub use error::HostError;
pub use grid::{Grid, Region};
pub use instance::ParamSettings;
pub use library::Library;
pub use material::Material;
pub use messages::Message;
pub use plugin_info::{ParamInfo, ParamKind, ParamValue, PluginInfo, PluginKind};
pub use probe::{Finding, probe_device};
pub use process_end::{end_at_once, end_by_itself, end_with_parent, guard_exit};
pub use realtime_rights::realtime_rights;
pub use search_path::{FoundLibrary, SearchPath};
pub use trust::AllowedFolders;
