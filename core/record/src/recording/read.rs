//! Reading a recording: all of it, or a sentence on what is wrong with it.

use super::digest::Digest;
use super::encoding::ByteReader;
use super::format::{
    COMMAND, DEVICE, END, HEADER, IDLE, LAPSE, MAGIC, OLDEST_VERSION, RecordedFile, RecordedStep, RecordingHeader,
    STEP, VERSION,
};
use pliant_engine::session::{Lapse, SessionCommand};
use pliant_host::{DeviceInfo, check_device_info};
use pliant_mesh::read::{RECORDING_LIMIT, read_file};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a file is not a recording that this program can replay.
#[derive(Debug, Error)]
#[error("{}: {reason}", path.display())]
pub struct RecordingError {
    path: PathBuf,
    reason: String,
}

/// A whole recording.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Where the recording comes from and what it needs.
    pub header: RecordingHeader,
    /// Names and limits of the devices, in the order of the steps' poses.
    pub devices: Vec<(String, DeviceInfo)>,
    /// Bodies that were given up because their plugins took too long.
    pub lapses: Vec<Lapse>,
    /// The steps in order.
    pub steps: Vec<RecordedStep>,
    /// Settings of the scene, key and value as of `--set`, by which a replay finds a model that stands beside the recording.
    pub settings: Vec<(String, String)>,
}

/// Bytes in front of the first block: magic and version.
const START: usize = MAGIC.len() + size_of::<u32>();

impl Recording {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, is not a recording, has another version, ends too soon, or was changed.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let wrong = |reason: String| RecordingError { path: path.to_path_buf(), reason };
        let bytes = read_file(path, RECORDING_LIMIT).map_err(|e| wrong(format!("cannot be read: {e}")))?;
        let mut recording = Self::parse(&bytes, path)?;
        recording.use_original(&original_of(path));
        Ok(recording)
    }

    /// Takes the model beside the recording in the place of the first body's, if that has changed or gone and this one is as it was.
    fn use_original(&mut self, original: &Path) {
        let is_as_recorded = |path: &Path, digest| Digest::of_file(path).is_ok_and(|now| now == digest);
        let Some(model) = self.header.files.iter_mut().find(|file| !file.plugin) else { return };
        if !is_as_recorded(&model.path, model.digest) && is_as_recorded(original, model.digest) {
            model.path = original.to_path_buf();
            let path = std::path::absolute(original).unwrap_or_else(|_| original.to_path_buf());
            self.settings.push(("body.0.mesh".into(), format!("{:?}", path.display().to_string())));
        }
    }

    /// Parses the bytes of a recording; `name` stands for its file in errors.
    ///
    /// # Errors
    /// Bytes that are not a recording, have another version, end too soon, or were changed.
    pub fn parse(bytes: &[u8], name: &Path) -> Result<Self, RecordingError> {
        Self::blocks(bytes).map_err(|reason| RecordingError { path: name.to_path_buf(), reason })
    }

    /// The recording in a file's bytes, or what is wrong with them.
    fn blocks(bytes: &[u8]) -> Result<Self, String> {
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
        let (mut header, mut devices, mut lapses) = (None, Vec::new(), Vec::new());
        let (mut steps, mut commands, mut taken) = (Vec::<RecordedStep>::new(), Vec::new(), 0_u64);
        let mut tools = None;
        loop {
            let (kind, content) = next_block(&mut left, &mut digest).ok_or_else(|| cut_off(whole, steps.len()))?;
            let broken = || {
                let at = whole - left.0.len() - content.len();
                format!("changed: the block of kind {kind} with its content at byte {at} cannot be decoded")
            };
            let mut content = ByteReader(content);
            match kind {
                HEADER => header = Some(serde_json::from_slice::<RecordingHeader>(content.0).map_err(|_| broken())?),
                DEVICE => {
                    let (name, facts) = content.device().ok_or_else(broken)?;
                    check_device_info(&facts).map_err(|reason| format!("changed: device `{name}`: {reason}"))?;
                    devices.push((name, facts));
                }
                LAPSE => lapses.push(content.lapse().ok_or_else(broken)?),
                STEP => {
                    let effectors = devices.iter().map(|(_, facts)| facts.effectors).collect::<Vec<_>>();
                    let step =
                        decode_step(&mut content, &effectors, std::mem::take(&mut commands)).ok_or_else(broken)?;
                    // Every step has as many tools as the first.
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
                    return Ok(Self { header, devices, lapses, steps, settings: Vec::new() });
                }
                _ => return Err(broken()),
            }
        }
    }

    /// Number of steps, idle ones included.
    pub fn step_count(&self) -> u64 {
        self.steps.iter().map(|step| u64::from(step.count)).sum()
    }

    /// Models and plugins that are not what they were when the session was recorded, each with what is wrong with it.
    pub fn changed_files(&self) -> impl Iterator<Item = (&RecordedFile, &'static str)> {
        self.header.files.iter().filter_map(|file| match Digest::of_file(&file.path) {
            Err(_) => Some((file, "cannot be read")),
            Ok(digest) => (digest != file.digest).then_some((file, "has changed")),
        })
    }
}

/// Where the first body's model stands beside a recording, as it was when the session was opened: `NAME.original.obj` beside `NAME.rec`.
pub fn original_of(recording: &Path) -> PathBuf {
    recording.with_extension("original.obj")
}

/// What is said of a file that ends too soon.
fn cut_off(bytes: usize, steps: usize) -> String {
    format!("cut off: it ends after {bytes} bytes and {steps} whole steps, without an end")
}

/// Kind and content of the next block, which the digest takes in; `None` where the bytes end too soon.
fn next_block<'a>(left: &mut ByteReader<'a>, digest: &mut Digest) -> Option<(u8, &'a [u8])> {
    let head = left.bytes(5)?;
    let length = u32::from_le_bytes([head[1], head[2], head[3], head[4]]);
    let content = left.bytes(length as usize)?;
    digest.bytes(head);
    digest.bytes(content);
    Some((head[0], content))
}

/// The step in a block, of devices with so many effectors each.
fn decode_step(content: &mut ByteReader<'_>, effectors: &[u32], commands: Vec<SessionCommand>) -> Option<RecordedStep> {
    let poses = effectors.iter().map(|n| (0..*n).map(|_| content.pose()).collect::<Option<Vec<_>>>());
    let poses = poses.collect::<Option<Vec<_>>>()?;
    let mut device_forces = Vec::new();
    // All that is left but the digest.
    while content.0.len() > size_of::<u64>() {
        device_forces.push(content.vector()?);
    }
    Some(RecordedStep { commands, count: 1, poses, device_forces, digest: content.u64()? })
}
