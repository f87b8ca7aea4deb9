//! The file format of recordings.
//!
//! A recording contains the scene with its settings, the poses of all hands in every step, and the effects of wall-clock time. Everything else
//! follows from these, so a replay gives the same bytes with the same program and plugins, without devices.
//!
//! A file is little-endian: `PLIANTRC`, version (u32), blocks of a kind (u8), a length (u32) and a content, and finally the digest of all bytes
//! before it (u64). The kinds are: `H`, the header as JSON; `D`, a device with its counts, limits, workspace, peak torque (since version 4) and name; `L`, a body that was stopped for taking too
//! long; `C`, a command before the next step; `S`, a step with the poses and device forces of all effectors, in the order of the devices, and the
//! digest of the state after it; `I`, the number of idle steps that follow it, in which no hand was present and neither forces nor state changed;
//! `E`, the number of steps. Seeds are parameters of devices, and thus part of the scene.

use super::recorded_path;
use crate::session::SessionCommand;
use pliant_host::Pose;
use pliant_solver::Vec3;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// First bytes of a recording.
pub const MAGIC: &[u8; 8] = b"PLIANTRC";
/// Version of the format this program writes. It reads older ones too: version 3 has no commands on sculpt layers, on
/// parts of bodies and on brushes, and no peak torques of devices, version 2 no command that sets a stiffness, version 1 neither commands nor idle steps.
pub const VERSION: u32 = 4;
/// First version with the peak torque of a device; in older ones it is 0, not known.
pub const PEAK_TORQUE_VERSION: u32 = 4;
/// Oldest version it reads.
pub const OLDEST_VERSION: u32 = 1;
/// Kind of the block with the header.
pub const HEADER: u8 = b'H';
/// Kind of a block with a device.
pub const DEVICE: u8 = b'D';
/// Kind of a block with a body that was stopped for taking too long.
pub const TIMEOUT: u8 = b'L';
/// Kind of a block with a command.
pub const COMMAND: u8 = b'C';
/// Kind of a block with a number of idle steps.
pub const IDLE: u8 = b'I';
/// Kind of a block with a step.
pub const STEP: u8 = b'S';
/// Kind of the last block, with the number of steps.
pub const END: u8 = b'E';

/// First byte of the content of a block with a command. A code is never used for another command.
pub mod command_code {
    /// Code of [`SessionCommand::Undo`](crate::session::SessionCommand::Undo).
    pub const UNDO: u8 = 0;
    /// Code of [`SessionCommand::Redo`](crate::session::SessionCommand::Redo).
    pub const REDO: u8 = 1;
    /// Code of [`SessionCommand::ResizeTools`](crate::session::SessionCommand::ResizeTools).
    pub const RESIZE_TOOLS: u8 = 2;
    /// Code of [`SessionCommand::SetStiffness`](crate::session::SessionCommand::SetStiffness).
    pub const SET_STIFFNESS: u8 = 3;
    /// Code of [`SessionCommand::AddLayer`](crate::session::SessionCommand::AddLayer).
    pub const ADD_LAYER: u8 = 4;
    /// Code of [`SessionCommand::RenameLayer`](crate::session::SessionCommand::RenameLayer).
    pub const RENAME_LAYER: u8 = 5;
    /// Code of [`SessionCommand::RecordLayer`](crate::session::SessionCommand::RecordLayer).
    pub const RECORD_LAYER: u8 = 6;
    /// Code of [`SessionCommand::SetLayerStrength`](crate::session::SessionCommand::SetLayerStrength).
    pub const SET_LAYER_STRENGTH: u8 = 7;
    /// Code of [`SessionCommand::MergeLayer`](crate::session::SessionCommand::MergeLayer).
    pub const MERGE_LAYER: u8 = 8;
    /// Code of [`SessionCommand::DeleteLayer`](crate::session::SessionCommand::DeleteLayer).
    pub const DELETE_LAYER: u8 = 9;
    /// Code of [`SessionCommand::SplitBody`](crate::session::SessionCommand::SplitBody).
    pub const SPLIT_BODY: u8 = 10;
    /// Code of [`SessionCommand::SetBrush`](crate::session::SessionCommand::SetBrush).
    pub const SET_BRUSH: u8 = 11;
    /// Code of [`SessionCommand::SetSymmetry`](crate::session::SessionCommand::SetSymmetry).
    pub const SET_SYMMETRY: u8 = 12;
}

/// Origin and requirements of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordingHeader {
    /// Program and version that made the recording.
    pub program: String,
    /// Path of the scene; paths of models are relative to its folder.
    #[serde(with = "recorded_path")]
    pub scene: PathBuf,
    /// Text of the scene, with `--set` applied.
    pub text: String,
    /// Model that replaces the first body's (`--mesh`).
    #[serde(with = "recorded_path::optional", default)]
    pub mesh: Option<PathBuf>,
    /// Whether the run was live: tips on sheets are then driven by the virtual coupling.
    pub live: bool,
    /// Whether the session kept a history for undo that the scene itself does not need.
    #[serde(default)]
    pub history: bool,
    /// Plugins that were opened, without devices, models, and files of fields.
    pub files: Vec<RecordedFile>,
}

/// A file that a session depends on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedFile {
    /// Absolute path at the time of recording.
    #[serde(with = "recorded_path")]
    pub path: PathBuf,
    /// [`Digest`](super::Digest) of its content.
    pub digest: u64,
    /// Whether the file is a plugin, which may be another build in a replay; other files must be unchanged.
    pub plugin: bool,
}

/// A step of a recording, or several equal ones.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedStep {
    /// Commands before the step, in order.
    pub commands: Vec<SessionCommand>,
    /// Number of equal steps, at least 1.
    pub count: u32,
    /// Poses of each effector of each device, in the order of the devices.
    pub poses: Vec<Vec<Pose>>,
    /// Force that each tool's effector was given last, N, in the axes of its device.
    pub device_forces: Vec<Vec3>,
    /// [`state_digest`](super::state_digest) after the step.
    pub digest: u64,
}
