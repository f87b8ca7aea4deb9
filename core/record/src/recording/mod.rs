//! A session in one file: the scene as it was run, the hands of every step, and what the wall clock decided. Everything else
//! follows from these, so a replay gives the same bytes on the same program and plugins, with no device there.
//!
//! The file, little-endian: `PLIANTRC`, version (u32), then blocks of a kind (u8), a length (u32) and a content, and last the
//! digest of all before it (u64). Kinds: `H` the header as JSON; `D` a device, its limits and name; `L` a body given up by
//! the clock; `S` a step: poses and given forces of all effectors, in the order of the devices, and the digest of the state
//! after it; `E` the number of steps. Seeds are parameters of devices, and so stand in the scene.

mod bytes;
mod digest;
mod read;
mod write;

pub use digest::Digest;
pub use read::{Recording, RecordingError};
pub use write::{RecordedStep, RecordingWriter};

use pliant_engine::session::Session;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// First bytes of a recording.
const MAGIC: &[u8; 8] = b"PLIANTRC";
/// The version of the format this program writes and reads.
const VERSION: u32 = 1;
/// Kinds of blocks.
const HEADER: u8 = b'H';
const DEVICE: u8 = b'D';
const LAPSE: u8 = b'L';
const STEP: u8 = b'S';
const END: u8 = b'E';

/// What a recording says of itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// The program that made it.
    pub program: String,
    /// File of the scene; its folder is where models are looked for.
    pub scene: PathBuf,
    /// The scene, `--set` included.
    pub text: String,
    /// Another model that took the place of the first body's.
    pub mesh: Option<PathBuf>,
    /// Whether real time was kept: tips on sheets then hang on their hands by a spring.
    pub live: bool,
    /// Plugins that were open, and models.
    pub files: Vec<RecordedFile>,
}

/// A file a session depends on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedFile {
    /// Where it was.
    pub path: PathBuf,
    /// Digest of its content.
    pub digest: u64,
    /// Whether it is a plugin, which another build may replace, or a model, which nothing may.
    pub plugin: bool,
}

/// Of the state of a session: nodes of every body, and what its tools feel.
pub fn state_digest(session: &Session) -> u64 {
    let mut digest = Digest::default();
    for body in &session.bodies {
        let nodes = &body.system.nodes;
        digest.word(nodes.len() as u64);
        nodes.x.iter().chain(&nodes.v).for_each(|of_node| digest.numbers(of_node));
    }
    for tool in &session.frame().tools {
        digest.numbers(&tool.proxy);
        digest.numbers(&tool.force);
    }
    digest.value()
}
