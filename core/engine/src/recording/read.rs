//! Reading and checking of recordings.

use super::decoding::ByteReader;
use super::digest::Digest;
use super::format::{
    COMMAND, DEVICE, END, HEADER, IDLE, MAGIC, OLDEST_VERSION, RecordedFile, RecordedStep, RecordingHeader, STEP,
    TIMEOUT, VERSION,
};
use crate::session::{SessionCommand, StepTimeout};
use pliant_host::{DeviceInfo, check_device_info};
use pliant_mesh::read::{RECORDING_LIMIT, read_file};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The error of a file that is not a recording this program can replay.
#[derive(Debug, Error)]
#[error("{}: {reason}", path.display())]
pub struct RecordingError {
    /// Path of the file.
    path: PathBuf,
    /// What is wrong with it.
    reason: String,
}

impl RecordingError {
    /// The error of the recording at `path`.
    pub(super) fn new(path: &Path, reason: String) -> Self {
        Self { path: path.to_path_buf(), reason }
    }
}

/// What a recording holds: its scene, what hands did, and what the run gave.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Origin and requirements of the recording.
    pub header: RecordingHeader,
    /// Names and descriptions of the devices, in the order of the poses of a step.
    pub devices: Vec<(String, DeviceInfo)>,
    /// Bodies that were stopped because their plugins took too long.
    pub timeouts: Vec<StepTimeout>,
    /// The steps in order.
    pub steps: Vec<RecordedStep>,
    /// Settings of the scene, keys and values as for `--set`, by which a replay uses a model beside the recording.
    pub settings: Vec<(String, String)>,
}

/// Bytes before the first block: magic and version.
const START: usize = MAGIC.len() + size_of::<u32>();

impl Recording {
    /// Reads a file.
    ///
    /// # Errors
    /// Fails for a file that cannot be read, is not a recording, has another version, is truncated or was changed.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let wrong = |reason| RecordingError::new(path, reason);
        let bytes = read_file(path, RECORDING_LIMIT).map_err(|e| wrong(format!("cannot be read: {e}")))?;
        let mut recording = Self::parse(&bytes, path)?;
        recording.use_original(&original_of(path));
        Ok(recording)
    }

    /// Uses the model `original` for the first body, if the body's own file has changed or is missing and `original` is as it was recorded.
    fn use_original(&mut self, original: &Path) {
        let is_as_recorded = |path: &Path, digest| Digest::of_file(path).is_ok_and(|now| now == digest);
        let Some(model) = self.header.files.iter_mut().find(|file| !file.plugin) else { return };
        if !is_as_recorded(&model.path, model.digest) && is_as_recorded(original, model.digest) {
            let path = std::path::absolute(original).unwrap_or_else(|_| original.to_path_buf());
            // A mesh in the place of the scene's own is asked for by its path.
            if self.header.mesh.as_ref() == Some(&model.path) {
                self.header.mesh = Some(path.clone());
            }
            model.path = original.to_path_buf();
            self.settings.push(("body.0.mesh".into(), format!("{:?}", path.display().to_string())));
        }
    }

    /// Parses the bytes of a recording; `name` is its path in errors.
    ///
    /// # Errors
    /// Fails for bytes that are not a recording, have another version, are truncated or were changed.
    pub fn parse(bytes: &[u8], name: &Path) -> Result<Self, RecordingError> {
        Self::parse_blocks(bytes).map_err(|reason| RecordingError::new(name, reason))
    }

    /// Parses the bytes of a recording; the error says what is wrong with them.
    fn parse_blocks(bytes: &[u8]) -> Result<Self, String> {
        let whole = bytes.len();
        let mut left = ByteReader(bytes);
        let magic = left.bytes(MAGIC.len()).unwrap_or_default();
        if magic != MAGIC {
            return Err("not a recording: it does not begin with PLIANTRC".into());
        }
        let version = left.u32().ok_or_else(|| cut_off(whole, 0))?;
        if !(OLDEST_VERSION..=VERSION).contains(&version) {
            return Err(format!("a recording of version {version}; allowed are {OLDEST_VERSION} to {VERSION}"));
        }
        let mut digest = Digest::default();
        digest.bytes(&bytes[..START]);
        let (mut header, mut devices, mut timeouts) = (None, Vec::new(), Vec::new());
        let (mut steps, mut commands, mut taken) = (Vec::<RecordedStep>::new(), Vec::new(), 0_u64);
        let mut tools = None;
        loop {
            let block = next_block(&mut left, &mut digest).ok_or_else(|| cut_off(whole, steps.len()))?;
            let Block { kind, content } = block;
            let broken = || {
                let at = whole - left.0.len() - content.len();
                format!("changed: the block of kind {kind} with its content at byte {at} cannot be decoded")
            };
            let mut content = ByteReader(content);
            match kind {
                HEADER => header = Some(serde_json::from_slice::<RecordingHeader>(content.0).map_err(|_| broken())?),
                DEVICE => {
                    let (name, info) = content.device(version).ok_or_else(broken)?;
                    check_device_info(&info).map_err(|reason| format!("changed: device `{name}`: {reason}"))?;
                    devices.push((name, info));
                }
                TIMEOUT => timeouts.push(content.timeout().ok_or_else(broken)?),
                STEP => {
                    let effectors = devices.iter().map(|(_, info)| info.effectors).collect::<Vec<_>>();
                    let step =
                        decode_step(&mut content, &effectors, std::mem::take(&mut commands)).ok_or_else(broken)?;
                    // All steps have the number of tools of the first.
                    if *tools.get_or_insert(step.device_forces.len()) != step.device_forces.len() {
                        return Err(broken());
                    }
                    steps.push(step);
                    taken += 1;
                }
                COMMAND => commands.push(content.command().ok_or_else(broken)?),
                IDLE => {
                    let count = content.u32().ok_or_else(broken)?;
                    let last = steps.last_mut().filter(|_| commands.is_empty()).ok_or_else(broken)?;
                    last.count = last.count.checked_add(count).ok_or_else(broken)?;
                    taken += u64::from(count);
                }
                END => {
                    let stated = content.u64().ok_or_else(broken)?;
                    let checksum = left.u64().ok_or_else(|| cut_off(whole, steps.len()))?;
                    if checksum != digest.value() {
                        return Err(format!(
                            "changed since it was written: its checksum is {checksum:016x}, that of its content {:016x}",
                            digest.value()
                        ));
                    }
                    if stated != taken || !left.0.is_empty() {
                        return Err(format!("changed: {taken} steps of {stated}, {} bytes too many", left.0.len()));
                    }
                    let header = header.ok_or("changed: it has no header")?;
                    return Ok(Self { header, devices, timeouts, steps, settings: Vec::new() });
                }
                _ => return Err(broken()),
            }
        }
    }

    /// Number of steps, idle ones included.
    pub fn step_count(&self) -> u64 {
        self.steps.iter().map(|step| u64::from(step.count)).sum()
    }

    /// Models and plugins that have changed since the session was recorded, each with the reason.
    pub fn changed_files(&self) -> impl Iterator<Item = (&RecordedFile, &'static str)> {
        self.header.files.iter().filter_map(|file| match Digest::of_file(&file.path) {
            Err(_) => Some((file, "cannot be read")),
            Ok(digest) => (digest != file.digest).then_some((file, "has changed")),
        })
    }
}

/// Path of the copy of the first body's model beside a recording: `NAME.original.obj` beside `NAME.rec`.
pub fn original_of(recording: &Path) -> PathBuf {
    recording.with_extension("original.obj")
}

/// The message for a truncated file.
fn cut_off(bytes: usize, steps: usize) -> String {
    format!("cut off: it ends after {bytes} bytes and {steps} whole steps, without an end")
}

/// A block of a recording.
struct Block<'a> {
    /// Kind, such as [`STEP`].
    kind: u8,
    /// Bytes of the block, without its head and checksum.
    content: &'a [u8],
}

/// Reads the next block and adds it to the digest; `None` if there are too few bytes.
fn next_block<'a>(left: &mut ByteReader<'a>, digest: &mut Digest) -> Option<Block<'a>> {
    let head = left.bytes(5)?;
    let length = u32::from_le_bytes([head[1], head[2], head[3], head[4]]);
    let content = left.bytes(length as usize)?;
    digest.bytes(head);
    digest.bytes(content);
    Some(Block { kind: head[0], content })
}

/// Decodes the content of a step; `effectors` is the number of effectors of each device.
fn decode_step(content: &mut ByteReader<'_>, effectors: &[u32], commands: Vec<SessionCommand>) -> Option<RecordedStep> {
    let poses = effectors.iter().map(|n| (0..*n).map(|_| content.pose()).collect::<Option<Vec<_>>>());
    let poses = poses.collect::<Option<Vec<_>>>()?;
    let mut device_forces = Vec::new();
    // The forces are followed by the digest.
    while content.0.len() > size_of::<u64>() {
        device_forces.push(content.vector()?);
    }
    Some(RecordedStep { commands, count: 1, poses, device_forces, digest: content.u64()? })
}
