//! Reading a recording: all of it, or a sentence on what is wrong with it.

use super::digest::Digest;
use super::encoding::ByteReader;
use super::format::{DEVICE, END, HEADER, LAPSE, MAGIC, RecordedFile, RecordedStep, RecordingHeader, STEP, VERSION};
use pliant_engine::session::Lapse;
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
        Self::parse(&bytes, path)
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
        if version != VERSION {
            return Err(format!("a recording of version {version}; allowed is {VERSION}, the one this program reads"));
        }
        let mut digest = Digest::default();
        digest.bytes(&bytes[..START]);
        let (mut header, mut devices, mut lapses, mut steps) = (None, Vec::new(), Vec::new(), Vec::new());
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
                    let step = decode_step(&mut content, &effectors).ok_or_else(broken)?;
                    // Every step has as many tools as the first.
                    if *tools.get_or_insert(step.device_forces.len()) != step.device_forces.len() {
                        return Err(broken());
                    }
                    steps.push(step);
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
                    if stated != steps.len() as u64 || !left.0.is_empty() {
                        return Err(format!(
                            "changed: {} steps of {stated}, {} bytes too many",
                            steps.len(),
                            left.0.len()
                        ));
                    }
                    let header = header.ok_or("changed: it has no header")?;
                    return Ok(Self { header, devices, lapses, steps });
                }
                _ => return Err(broken()),
            }
        }
    }

    /// Models and plugins that are not what they were when the session was recorded, each with what is wrong with it.
    pub fn changed_files(&self) -> impl Iterator<Item = (&RecordedFile, &'static str)> {
        self.header.files.iter().filter_map(|file| match Digest::of_file(&file.path) {
            Err(_) => Some((file, "cannot be read")),
            Ok(digest) => (digest != file.digest).then_some((file, "has changed")),
        })
    }
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
fn decode_step(content: &mut ByteReader<'_>, effectors: &[u32]) -> Option<RecordedStep> {
    let poses = effectors.iter().map(|n| (0..*n).map(|_| content.pose()).collect::<Option<Vec<_>>>());
    let poses = poses.collect::<Option<Vec<_>>>()?;
    let mut device_forces = Vec::new();
    // All that is left but the digest.
    while content.0.len() > size_of::<u64>() {
        device_forces.push(content.vector()?);
    }
    Some(RecordedStep { poses, device_forces, digest: content.u64()? })
}
