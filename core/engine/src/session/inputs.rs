//! What a session was opened from: plugins, files and recordings, and what their bodies were estimated to take.

use crate::memory::BodyMemory;
use crate::recording::RecordedHands;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;

/// A plugin that was loaded.
#[derive(Clone, Debug, Serialize)]
pub struct Loaded {
    /// Kind: grid, material or device.
    pub kind: &'static str,
    /// Id of the plugin.
    pub id: String,
    /// Version of the plugin.
    pub version: String,
    /// Library it was loaded from.
    pub path: String,
}

/// What was read and loaded when a session was opened; it does not change afterwards.
#[derive(Default)]
pub struct Inputs {
    /// Plugins that were loaded.
    pub loaded: Vec<Loaded>,
    /// Files of fields, fibres and textures of pins that were read.
    pub field_files: Vec<PathBuf>,
    /// Meshes of obstacles that were read.
    pub obstacle_files: Vec<PathBuf>,
    /// Recordings that devices take their hands from, each once.
    pub recordings: Vec<Arc<RecordedHands>>,
    /// Estimate of the memory of each body of the scene, made before it was allocated.
    pub memory: Vec<BodyMemory>,
}
