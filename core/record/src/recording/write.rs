//! Writing a recording, step by step.

use super::digest::{Digest, state_digest};
use super::encoding::{put_command, put_device, put_lapse, put_numbers, put_pose};
use super::format::{COMMAND, DEVICE, END, HEADER, IDLE, LAPSE, MAGIC, RecordedFile, RecordingHeader, STEP, VERSION};
use super::read::original_of;
use crate::atomic::{AtomicFile, error_at, folder_of, remove_leftovers};
use crate::inputs::refuse_inputs;
use pliant_engine::scene::{Scene, Source};
use pliant_engine::session::{Session, SessionCommand};
use pliant_host::POSE_VALID;
use pliant_solver::Vec3;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Bytes that are collected before they go to the file without a name: a step of a hand is some 250.
const BUFFER: usize = 1 << 16;

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
    /// Whether the session keeps what undo needs ([`Session::keep_history`]).
    pub history: bool,
}

/// A recording that is being made, in a file that appears under its name when it is whole, or in one that [`RecordingWriter::save_as`]
/// copies.
pub struct RecordingWriter<W = AtomicFile> {
    file: W,
    /// Content of the block that comes next.
    block: Vec<u8>,
    digest: Digest,
    steps: u64,
    /// Lapses of the session that are already written.
    lapses: usize,
    /// Forces and digest of the last step, as bytes; empty if a hand was present in it or a command comes next.
    last: Vec<u8>,
    /// Those of the step that is being written.
    next: Vec<u8>,
    /// Steps since then that were idle.
    idle: u32,
    /// Digest of the first model's file when the recording began; `None` without one.
    model: Option<u64>,
}

impl RecordingWriter {
    /// Begins the recording that will be `path`.
    ///
    /// # Errors
    /// A file that cannot be written, that the session was opened from, or one of the scene's that cannot be read, with its path.
    pub fn create(path: &Path, inputs: &RecordingInputs<'_>) -> io::Result<Self> {
        refuse_inputs(std::iter::once(path.to_path_buf()), inputs.source, inputs.session)?;
        let file = AtomicFile::create(path)?;
        remove_leftovers(folder_of(path));
        Self::begin(file, inputs)
    }

    /// Ends the recording and gives it its name.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.put_idle()?;
        let end = self.end();
        self.file.write_all(&end)?;
        self.file.finish()
    }
}

impl RecordingWriter<BufWriter<File>> {
    /// Begins a recording in a file without a name, to be copied by [`RecordingWriter::save_as`].
    ///
    /// # Errors
    /// A system without temporary files, or a file of the scene's that cannot be read, with its path.
    pub fn unnamed(inputs: &RecordingInputs<'_>) -> io::Result<Self> {
        Self::begin(BufWriter::with_capacity(BUFFER, tempfile::tempfile()?), inputs)
    }

    /// Writes what was recorded so far to `path`; recording goes on. With `with_model` the model of the first body, as it was opened, goes to
    /// [`original_of`] that path, for a replay to find if its own file is written over.
    ///
    /// # Errors
    /// A file that the session was opened from, one that cannot be read or written, or a model that has changed between its opening and the
    /// beginning of the recording, with its path; what was there before stays.
    pub fn save_as(&mut self, path: &Path, source: &Source, session: &Session, with_model: bool) -> io::Result<()> {
        let original =
            session.bodies.first().filter(|_| with_model).map(|body| (original_of(path), &body.model.document));
        let outputs = original.iter().map(|(path, _)| path.clone()).chain([path.to_path_buf()]);
        refuse_inputs(outputs, source, session)?;
        if let Some((path, document)) = original {
            if Some(Digest::of(document.bytes())) != self.model {
                return Err(error_at(document.name(), io::Error::other("changed while the session was opened")));
            }
            let mut file = AtomicFile::create(&path)?;
            file.write_all(document.bytes()).map_err(|e| error_at(&path, e))?;
            file.finish()?;
        }
        self.put_idle()?;
        self.file.flush()?;
        let (end, mut copy) = (self.end(), AtomicFile::create(path)?);
        let recorded = self.file.get_mut();
        recorded.rewind()?;
        let copied = io::copy(recorded, &mut copy).map_err(|e| error_at(path, e));
        recorded.seek(SeekFrom::End(0))?;
        copied?;
        copy.write_all(&end).map_err(|e| error_at(path, e))?;
        copy.finish()
    }
}

impl<W: Write> RecordingWriter<W> {
    fn begin(mut file: W, inputs: &RecordingInputs<'_>) -> io::Result<Self> {
        let RecordingInputs { source, session, mesh, live, history, .. } = *inputs;
        let header = RecordingHeader {
            program: format!("pliant {}", env!("CARGO_PKG_VERSION")),
            scene: absolute(&source.path)?,
            text: source.text.clone(),
            mesh: mesh.map(absolute).transpose()?,
            live,
            history,
            files: files(inputs)?,
        };
        let (mut start, mut digest) = (MAGIC.to_vec(), Digest::default());
        start.extend_from_slice(&VERSION.to_le_bytes());
        file.write_all(&start)?;
        digest.bytes(&start);
        let block = serde_json::to_vec(&header)?;
        let model = header.files.iter().find(|file| !file.plugin).map(|file| file.digest);
        let mut writer =
            Self { file, block, digest, steps: 0, lapses: 0, last: Vec::new(), next: Vec::new(), idle: 0, model };
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
        self.next.clear();
        device_forces.for_each(|force| put_numbers(&mut self.next, force.as_slice()));
        self.next.extend_from_slice(&state_digest(session).to_le_bytes());
        let mut poses = session.devices.iter().flat_map(|slot| slot.poses());
        let is_absent = poses.all(|pose| pose.flags & POSE_VALID == 0 && pose.buttons == 0);
        let lapses = &session.lapses()[self.lapses..];
        self.steps += 1;
        // A pose that is not valid has no effect, so this step repeats the last one.
        if is_absent && lapses.is_empty() && self.next == self.last {
            self.idle += 1;
            return if self.idle == u32::MAX { self.put_idle() } else { Ok(()) };
        }
        self.put_idle()?;
        for lapse in lapses {
            put_lapse(&mut self.block, lapse);
            self.put_block(LAPSE)?;
        }
        self.lapses = session.lapses().len();
        for pose in session.devices.iter().flat_map(|slot| slot.poses()) {
            put_pose(&mut self.block, pose);
        }
        self.block.extend_from_slice(&self.next);
        std::mem::swap(&mut self.last, &mut self.next);
        if !is_absent {
            self.last.clear();
        }
        self.put_block(STEP)
    }

    /// Writes a command that the session gets before its next step.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn command(&mut self, command: SessionCommand) -> io::Result<()> {
        self.put_idle()?;
        // The next step is written whole, for a command belongs to it.
        self.last.clear();
        put_command(&mut self.block, command);
        self.put_block(COMMAND)
    }

    /// Writes how many idle steps have gone by.
    fn put_idle(&mut self) -> io::Result<()> {
        if self.idle == 0 {
            return Ok(());
        }
        self.block.extend_from_slice(&self.idle.to_le_bytes());
        self.idle = 0;
        self.put_block(IDLE)
    }

    /// The last block, and the digest of the file with it.
    fn end(&self) -> Vec<u8> {
        let mut digest = self.digest;
        let (head, content) = (block_head(END, size_of::<u64>()), self.steps.to_le_bytes());
        digest.bytes(&head);
        digest.bytes(&content);
        [&head[..], &content, &digest.value().to_le_bytes()].concat()
    }

    /// Writes the content collected so far as a block, and empties it.
    fn put_block(&mut self, kind: u8) -> io::Result<()> {
        let head = block_head(kind, self.block.len());
        for part in [&head[..], &self.block] {
            self.file.write_all(part)?;
            self.digest.bytes(part);
        }
        self.block.clear();
        Ok(())
    }
}

/// Kind and length (bytes) of a block.
fn block_head(kind: u8, length: usize) -> [u8; 5] {
    let mut head = [kind, 0, 0, 0, 0];
    head[1..].copy_from_slice(&(length as u32).to_le_bytes());
    head
}

/// Models and plugins the session depends on, with their digests.
fn files(inputs: &RecordingInputs<'_>) -> io::Result<Vec<RecordedFile>> {
    let RecordingInputs { scene, source, session, mesh, .. } = *inputs;
    let own = scene.body.iter().enumerate().filter_map(|(i, body)| {
        let path = source.folder().join(body.mesh.as_ref()?.get_ref());
        (i > 0 || mesh.is_none() || path.is_file()).then_some(path)
    });
    // The models first: a replay takes the first of these files for that of the first body.
    let read = own.chain(mesh.map(Path::to_path_buf)).chain(session.field_files.iter().cloned());
    // Of a device only its limits and hands count, and those are in the recording.
    let plugins = session.loaded.iter().filter(|l| l.kind != "device").map(|l| (PathBuf::from(&l.path), true));
    let all = plugins.chain(read.map(|path| (path, false)));
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
