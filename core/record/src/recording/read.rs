//! Reading a session back: all of it, or a sentence on what is wrong.

use super::bytes::Taker;
use super::{DEVICE, Digest, END, HEADER, Header, LAPSE, MAGIC, RecordedFile, RecordedStep, STEP, VERSION};
use pliant_engine::session::Lapse;
use pliant_host::DeviceInfo;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a file is not a recording this program can replay.
#[derive(Debug, Error)]
#[error("{}: {what}", path.display())]
pub struct RecordingError {
    path: PathBuf,
    what: String,
}

/// A whole recording.
#[derive(Clone, Debug)]
pub struct Recording {
    /// What it says of itself.
    pub header: Header,
    /// Names and limits, in the order of the steps' poses.
    pub devices: Vec<(String, DeviceInfo)>,
    /// Bodies the clock gave up.
    pub lapses: Vec<Lapse>,
    /// In order.
    pub steps: Vec<RecordedStep>,
}

/// Bytes in front of the first block.
const START: usize = 12;

impl Recording {
    /// Reads a file.
    ///
    /// # Errors
    /// One that cannot be read, is none, has another version, ends too soon, or was changed.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let wrong = |what: String| RecordingError { path: path.to_path_buf(), what };
        let bytes = std::fs::read(path).map_err(|e| wrong(format!("cannot be read: {e}")))?;
        Self::parse(&bytes).map_err(wrong)
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let whole = bytes.len();
        let mut left = Taker(bytes);
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
        let mut shape = None;
        loop {
            let (kind, content) = block(&mut left, &mut digest).ok_or_else(|| cut_off(whole, steps.len()))?;
            let broken = || format!("changed: a block of kind {kind} at byte {} makes no sense", whole - left.0.len());
            let mut content = Taker(content);
            match kind {
                HEADER => header = Some(serde_json::from_slice::<Header>(content.0).map_err(|_| broken())?),
                DEVICE => devices.push(content.device().ok_or_else(broken)?),
                LAPSE => lapses.push(content.lapse().ok_or_else(broken)?),
                STEP => {
                    let effectors = devices.iter().map(|(_, facts)| facts.effectors).collect::<Vec<_>>();
                    steps.push(step(&mut content, &effectors).ok_or_else(broken)?);
                    let now = steps[steps.len() - 1].given.len();
                    if *shape.get_or_insert(now) != now {
                        return Err(broken());
                    }
                }
                END => {
                    let said = content.u64().ok_or_else(broken)?;
                    let sum = left.u64().ok_or_else(|| cut_off(whole, steps.len()))?;
                    if sum != digest.value() {
                        return Err(format!(
                            "changed since it was written: its checksum is {sum:016x}, that of its content {:016x}",
                            digest.value()
                        ));
                    }
                    if said != steps.len() as u64 || !left.0.is_empty() {
                        return Err(format!(
                            "changed: {} steps of {said}, {} bytes too many",
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

    /// Models that are no longer what they were, and plugins, by whether they are plugins.
    pub fn changed_files(&self) -> impl Iterator<Item = (&RecordedFile, &'static str)> {
        self.header.files.iter().filter_map(|file| match std::fs::read(&file.path) {
            Err(_) => Some((file, "cannot be read")),
            Ok(bytes) => (Digest::of(&bytes) != file.digest).then_some((file, "has changed")),
        })
    }
}

fn cut_off(bytes: usize, steps: usize) -> String {
    format!("cut off: it ends after {bytes} bytes and {steps} whole steps, without an end")
}

fn block<'a>(left: &mut Taker<'a>, digest: &mut Digest) -> Option<(u8, &'a [u8])> {
    let head = left.bytes(5)?;
    let length = u32::from_le_bytes([head[1], head[2], head[3], head[4]]);
    let content = left.bytes(length as usize)?;
    digest.bytes(head);
    digest.bytes(content);
    Some((head[0], content))
}

fn step(content: &mut Taker<'_>, effectors: &[u32]) -> Option<RecordedStep> {
    let poses = effectors.iter().map(|n| (0..*n).map(|_| content.pose()).collect::<Option<Vec<_>>>());
    let poses = poses.collect::<Option<Vec<_>>>()?;
    let mut given = Vec::new();
    while content.0.len() > 8 {
        given.push(content.vector()?);
    }
    Some(RecordedStep { poses, given, digest: content.u64()? })
}
