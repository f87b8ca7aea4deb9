//! Writing a recording, step by step.

use super::digest::{Digest, state_digest};
use super::encoding::{put_device, put_lapse, put_numbers, put_pose};
use super::format::{DEVICE, END, HEADER, LAPSE, MAGIC, RecordedFile, RecordingHeader, STEP, VERSION};
use crate::atomic::{AtomicFile, error_at, folder_of, remove_leftovers};
use crate::inputs::refuse_inputs;
use pliant_engine::scene::{Scene, Source};
use pliant_engine::session::Session;
use pliant_solver::Vec3;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What a recording is made of.
#[derive(Clone, Copy)]
pub struct RecordingInputs<'a> {
    /// The scene that is run.
    pub scene: &'a Scene,
    /// Its file and text.
    pub source: &'a Source,
    /// The session, just opened.
    pub session: &'a Session,
    /// Model that took the place of the first body's (`--mesh`).
    pub mesh: Option<&'a Path>,
    /// Whether the run keeps real time.
    pub live: bool,
}

/// A recording that is being made. It appears under its name when it is whole.
pub struct RecordingWriter {
    file: AtomicFile,
    /// Content of the block that comes next.
    block: Vec<u8>,
    digest: Digest,
    steps: u64,
    /// Lapses of the session that are already written.
    lapses: usize,
}

impl RecordingWriter {
    /// Begins the recording that will be `path`.
    ///
    /// # Errors
    /// A file that cannot be written, that the session was opened from, or one of the scene's that cannot be read, with its path.
    pub fn create(path: &Path, inputs: &RecordingInputs<'_>) -> io::Result<Self> {
        let RecordingInputs { source, session, mesh, live, .. } = *inputs;
        refuse_inputs(std::iter::once(path.to_path_buf()), source, session)?;
        let mut file = AtomicFile::create(path)?;
        remove_leftovers(folder_of(path));
        let header = RecordingHeader {
            program: format!("pliant {}", env!("CARGO_PKG_VERSION")),
            scene: absolute(&source.path)?,
            text: source.text.clone(),
            mesh: mesh.map(absolute).transpose()?,
            live,
            files: files(inputs)?,
        };
        let (mut start, mut digest) = (MAGIC.to_vec(), Digest::default());
        start.extend_from_slice(&VERSION.to_le_bytes());
        file.write_all(&start)?;
        digest.bytes(&start);
        let mut writer = Self { file, block: Vec::new(), digest, steps: 0, lapses: 0 };
        writer.block = serde_json::to_vec(&header)?;
        writer.put_block(HEADER)?;
        for slot in &session.devices {
            put_device(&mut writer.block, &slot.name, &slot.facts);
            writer.put_block(DEVICE)?;
        }
        Ok(writer)
    }

    /// Writes the step that the session has just taken. `device_forces` (N) are what each tool's effector was given while the step was
    /// under way, in the axes of its device.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn step(&mut self, session: &Session, device_forces: impl Iterator<Item = Vec3>) -> io::Result<()> {
        for lapse in &session.lapses()[self.lapses..] {
            put_lapse(&mut self.block, lapse);
            self.put_block(LAPSE)?;
        }
        self.lapses = session.lapses().len();
        for pose in session.devices.iter().flat_map(|slot| slot.poses()) {
            put_pose(&mut self.block, pose);
        }
        device_forces.for_each(|force| put_numbers(&mut self.block, force.as_slice()));
        self.block.extend_from_slice(&state_digest(session).to_le_bytes());
        self.steps += 1;
        self.put_block(STEP)
    }

    /// Ends the recording and gives it its name.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.block.extend_from_slice(&self.steps.to_le_bytes());
        self.put_block(END)?;
        self.file.write_all(&self.digest.value().to_le_bytes())?;
        self.file.finish()
    }

    /// Writes the content collected so far as a block, and empties it.
    fn put_block(&mut self, kind: u8) -> io::Result<()> {
        let mut head = [kind, 0, 0, 0, 0];
        head[1..].copy_from_slice(&(self.block.len() as u32).to_le_bytes());
        for part in [&head[..], &self.block] {
            self.file.write_all(part)?;
            self.digest.bytes(part);
        }
        self.block.clear();
        Ok(())
    }
}

/// Models and plugins the session depends on, with their digests.
fn files(inputs: &RecordingInputs<'_>) -> io::Result<Vec<RecordedFile>> {
    let RecordingInputs { scene, source, session, mesh, .. } = *inputs;
    let own = scene.body.iter().enumerate().filter_map(|(i, body)| {
        let path = source.folder().join(body.mesh.as_ref()?.get_ref());
        (i > 0 || mesh.is_none() || path.is_file()).then_some(path)
    });
    let models: Vec<PathBuf> = own.chain(mesh.map(Path::to_path_buf)).collect();
    // Of a device only its limits and hands count, and those are in the recording.
    let plugins = session.loaded.iter().filter(|l| l.kind != "device").map(|l| (PathBuf::from(&l.path), true));
    let all = plugins.chain(models.into_iter().map(|path| (path, false)));
    all.map(|(path, plugin)| {
        let path = absolute(&path)?;
        let digest = Digest::of_file(&path).map_err(|e| error_at(&path, e))?;
        Ok(RecordedFile { path, digest, plugin })
    })
    .collect()
}

/// The absolute form of a path; the error names the path.
fn absolute(path: &Path) -> io::Result<PathBuf> {
    std::path::absolute(path).map_err(|e| error_at(path, e))
}
