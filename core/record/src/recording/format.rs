//! What a recording holds: the scene as it was run, the hands of every step, and what the wall clock decided. Everything else
//! follows from these, so a replay gives the same bytes on the same program and plugins, with no device there.
//!
//! The file, little-endian: `PLIANTRC`, version (u32), then blocks of a kind (u8), a length (u32) and a content, and last the
//! digest of all before it (u64). Kinds: `H` the header as JSON; `D` a device, its limits and name; `L` a body given up by
//! the clock; `C` a command given before the next step; `S` a step: poses and device forces of all effectors, in the order of the
//! devices, and the digest of the state after it; `I` how many idle steps follow it: no hand was present, and neither forces nor
//! state changed; `E` the number of steps. Seeds are parameters of devices, and so they are part of the scene.

use pliant_engine::session::SessionCommand;
use pliant_host::Pose;
use pliant_solver::Vec3;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// First bytes of a recording.
pub(super) const MAGIC: &[u8; 8] = b"PLIANTRC";
/// Version of the format this program writes. It reads version 1 too, which has neither commands nor idle steps.
pub(super) const VERSION: u32 = 2;
/// Oldest version it reads.
pub(super) const OLDEST_VERSION: u32 = 1;
/// Kind of the block with the header.
pub(super) const HEADER: u8 = b'H';
/// Kind of a block with a device.
pub(super) const DEVICE: u8 = b'D';
/// Kind of a block with a body that was given up for taking too long.
pub(super) const LAPSE: u8 = b'L';
/// Kind of a block with a command.
pub(super) const COMMAND: u8 = b'C';
/// Kind of a block with a number of idle steps.
pub(super) const IDLE: u8 = b'I';
/// Kind of a block with a step.
pub(super) const STEP: u8 = b'S';
/// Kind of the last block, with the number of steps.
pub(super) const END: u8 = b'E';

/// Where a recording comes from and what it needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordingHeader {
    /// Program and version that made the recording.
    pub program: String,
    /// File of the scene; models are looked for relative to its folder.
    pub scene: PathBuf,
    /// Text of the scene, `--set` included.
    pub text: String,
    /// Model that took the place of the first body's (`--mesh`).
    pub mesh: Option<PathBuf>,
    /// Whether the run kept real time: tips on sheets then hang on their hands by a spring.
    pub live: bool,
    /// Whether the session kept what undo needs, besides what the scene's own edits need.
    #[serde(default)]
    pub history: bool,
    /// Plugins that were open, devices excepted, models, and files of fields.
    pub files: Vec<RecordedFile>,
}

/// A file that a session depends on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedFile {
    /// Absolute path at the time of recording.
    pub path: PathBuf,
    /// [`Digest`](super::Digest) of its content.
    pub digest: u64,
    /// Whether the file is a plugin. A plugin may be another build of the same; other files must be the same.
    pub plugin: bool,
}

/// One step of a recording, or several that are the same.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedStep {
    /// Given before the step, in this order.
    pub commands: Vec<SessionCommand>,
    /// How many steps in a row this was, at least 1.
    pub count: u32,
    /// Poses of each effector of each device, in the order of the devices.
    pub poses: Vec<Vec<Pose>>,
    /// N, the force last given to each tool's effector, in its device's axes
    pub device_forces: Vec<Vec3>,
    /// [`state_digest`](super::state_digest) after the step.
    pub digest: u64,
}
