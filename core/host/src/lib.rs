//! The host's side of the plugin interface: search of plugins, opening of their libraries, and safe calls into them.
//!
//! A [`SearchPath`] finds the file of a [`Library`] by the name of a plugin; a library lists its plugins ([`PluginInfo`]) without creating
//! them. An active plugin is a [`Grid`], a [`Material`], a [`Device`] or a [`ContactLaw`]. A material is a force model of the solver. Failures of plugins are
//! [`HostError`]s that name the file and the call.
//!
//! This crate knows no scenes, meshes or bodies, and names no plugin. It and `plugin-api` are the only places of the engine with
//! `unsafe`. A library is opened by absolute path, all symbols bound at once (`RTLD_NOW | RTLD_LOCAL`), and stays mapped until the
//! program ends: thread-locals, static strings and descriptors point into it. Opening a library runs its code, so a scene may
//! name libraries by path only in folders that the caller allows ([`AllowedFolders`]); by default there are none.
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
#![deny(clippy::wildcard_enum_match_arm)]

mod call_board;
mod calls;
mod choice_sources;
mod contact_law;
mod device;
mod directions;
mod elf;
mod error;
mod f32_tangent;
mod failure;
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
mod protected_memory;
mod realtime_rights;
mod search_path;
mod trust;

pub use call_board::{CallBoard, share_calls};
pub use calls::{PluginCall, plugin_calls};
pub use choice_sources::{ChoiceSource, choice_sources};
pub use contact_law::{ContactLaw, ContactStates, Tractions};
pub use device::{Device, DeviceInfo, EffectorOutput, MAX_EFFECTORS, POSE_VALID, Pose, StopHandle, check_device_info};
pub use error::HostError;
pub use grid::{Grid, LocatedPoint, Region};
pub use instance::ParamSettings;
pub use library::Library;
pub use material::Material;
pub use messages::{Message, NewMessages};
pub use plugin_info::{ParamInfo, ParamKind, ParamValue, PluginInfo, PluginKind};
pub use probe::{Finding, probe_device};
pub use process_end::{detect_plugin_exit, end_at_once, end_with_parent, record_exit_code};
pub use protected_memory::protected_memory;
pub use realtime_rights::realtime_rights;
pub use search_path::{FoundLibrary, SearchPath};
pub use trust::AllowedFolders;
