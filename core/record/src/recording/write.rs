//! Writing of recordings, step by step.

use super::encoding::{put_command, put_device, put_numbers, put_pose, put_timeout};
use crate::atomic::{AtomicFile, error_at};
use crate::output_paths::check_file;
use pliant_engine::recording::format::{
    COMMAND, DEVICE, END, HEADER, IDLE, MAGIC, RecordedFile, RecordingHeader, STEP, TIMEOUT, VERSION,
};
use pliant_engine::recording::{Digest, original_of, state_digest};
use pliant_engine::scene::{Scene, Source};
use pliant_engine::session::{Session, SessionCommand};
use pliant_host::POSE_VALID;
use pliant_mesh::ObjDocument;
use pliant_solver::Vec3;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Size of the write buffer of an unnamed file, bytes; a step of one hand has about 250.
const BUFFER: usize = 1 << 16;

/// Inputs of a recording.
#[derive(Clone, Copy)]
pub struct RecordingInputs<'a> {
    /// The scene that is run.
    pub scene: &'a Scene,
    /// Its file and text.
    pub source: &'a Source,
    /// The session, just opened.
    pub session: &'a Session,
    /// Model that replaces the first body's (`--mesh`).
    pub mesh: Option<&'a Path>,
    /// Whether the run is live.
    pub live: bool,
    /// Whether the session keeps a history for undo ([`Session::keep_history`]).
    pub history: bool,
}

/// Writes a recording: into a file that gets its name when it is complete, or into an unnamed file that [`RecordingWriter::save_as`] copies.
pub struct RecordingWriter<W = AtomicFile> {
    /// File or buffer that receives the recording.
    file: W,
    /// Content of the next block.
    block: Vec<u8>,
    /// Digest of all bytes written.
    digest: Digest,
    /// Number of steps so far, idle ones included.
    steps: u64,
    /// Number of timeouts of the session that are written.
    timeouts: usize,
    /// Encoded forces and state digest of the last step; empty if a hand was present in it or a command follows.
    last: Vec<u8>,
    /// Encoded forces and state digest of the step that is being written.
    next: Vec<u8>,
    /// Number of idle steps that are not written yet.
    idle: u32,
    /// Digest of the first model's file when the recording began; `None` without one.
    model: Option<u64>,
    /// Bytes of that file if the scene divides its faces (`subdivide`): the body has another document then.
    undivided: Option<Vec<u8>>,
}

impl RecordingWriter {
    /// Begins the recording that will be `path`.
    ///
    /// # Errors
    /// Fails for a file that cannot be written, is an input of the session or is no regular file, and for an input that cannot be read, with the path.
    pub fn create(path: &Path, inputs: &RecordingInputs<'_>) -> io::Result<Self> {
        check_file(path, inputs.source, inputs.session)?;
        let file = AtomicFile::create_and_clean(path)?;
        Self::begin(file, inputs)
    }

    /// Completes the recording and gives the file its name.
    ///
    /// # Errors
    /// Fails for a file that cannot be written.
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
    /// Fails if no temporary file can be created, and for an input that cannot be read, with the path.
    pub fn unnamed(inputs: &RecordingInputs<'_>) -> io::Result<Self> {
        Self::begin(BufWriter::with_capacity(BUFFER, tempfile::tempfile()?), inputs)
    }

    /// Writes the recording so far to `path`; recording goes on. With `with_model` the model of the first body, as it was opened, is written to
    /// [`original_of`] that path; a replay uses it if the model's own file is overwritten.
    ///
    /// # Errors
    /// Fails for a file that is an input of the session, is no regular file or cannot be read or written, and for a model that changed between its opening and the
    /// beginning of the recording, with the path. Existing files are then unchanged.
    pub fn save_as(&mut self, path: &Path, source: &Source, session: &Session, with_model: bool) -> io::Result<()> {
        let original =
            session.bodies.first().filter(|_| with_model).map(|body| (original_of(path), &body.model.document));
        for path in original.iter().map(|(path, _)| path.as_path()).chain([path]) {
            check_file(path, source, session)?;
        }
        if original.is_some() && session.bodies.first().is_some_and(|body| body.model.tetrahedra.is_some()) {
            let text = "the model is a tetrahedral mesh, of which no copy is saved with a recording; name it as `mesh` of the scene";
            return Err(error_at(path, io::Error::other(text)));
        }
        if let Some((path, document)) = original {
            let bytes = self.undivided.as_deref().unwrap_or(document.bytes());
            if Some(Digest::of(bytes)) != self.model || !begins_with(document, bytes) {
                return Err(error_at(document.name(), io::Error::other("changed while the session was opened")));
            }
            let mut file = AtomicFile::create(&path)?;
            file.write_all(bytes).map_err(|e| error_at(&path, e))?;
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
    /// Writes the header and the devices.
    fn begin(mut file: W, inputs: &RecordingInputs<'_>) -> io::Result<Self> {
        let RecordingInputs { source, session, mesh, live, history, .. } = *inputs;
        let header = RecordingHeader {
            program: format!("pliant {}", env!("CARGO_PKG_VERSION")),
            scene: absolute(&source.path)?,
            text: source.text.to_string(),
            mesh: mesh.map(absolute).transpose()?,
            live,
            history: history || session.keeps_history(),
            files: files(inputs)?,
        };
        let (mut start, mut digest) = (MAGIC.to_vec(), Digest::default());
        start.extend_from_slice(&VERSION.to_le_bytes());
        file.write_all(&start)?;
        digest.bytes(&start);
        let block = serde_json::to_vec(&header)?;
        let model = header.files.iter().find(|file| !file.plugin).map(|file| file.digest);
        let is_divided = session.bodies.first().is_some_and(|body| body.model.subdivision.is_some());
        let first = header.files.iter().find(|file| is_divided && !file.plugin);
        let undivided = first.map(|file| std::fs::read(&file.path).map_err(|e| error_at(&file.path, e))).transpose()?;
        let (last, next) = (Vec::new(), Vec::new());
        let mut writer = Self { file, block, digest, steps: 0, timeouts: 0, last, next, idle: 0, model, undivided };
        writer.put_block(HEADER)?;
        for slot in &session.devices {
            put_device(&mut writer.block, &slot.name, &slot.facts);
            writer.put_block(DEVICE)?;
        }
        Ok(writer)
    }

    /// Writes the last step of the session. `device_forces` (N) are the forces that the effector of each tool was given during the step, in the
    /// axes of its device.
    ///
    /// # Errors
    /// Fails for a file that cannot be written.
    pub fn step(&mut self, session: &Session, device_forces: impl Iterator<Item = Vec3>) -> io::Result<()> {
        for command in session.recorded_commands() {
            self.command(command)?;
        }
        self.next.clear();
        device_forces.for_each(|force| put_numbers(&mut self.next, force.as_slice()));
        self.next.extend_from_slice(&state_digest(session).to_le_bytes());
        let mut poses = session.devices.iter().flat_map(|slot| slot.poses());
        let is_absent = poses.all(|pose| pose.flags & POSE_VALID == 0 && pose.buttons == 0);
        let timeouts = &session.timeouts()[self.timeouts..];
        self.steps += 1;
        // Invalid poses have no effect, so this step equals the last one.
        if is_absent && timeouts.is_empty() && self.next == self.last {
            self.idle += 1;
            return if self.idle == u32::MAX { self.put_idle() } else { Ok(()) };
        }
        self.put_idle()?;
        for timeout in timeouts {
            put_timeout(&mut self.block, timeout);
            self.put_block(TIMEOUT)?;
        }
        self.timeouts = session.timeouts().len();
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
    /// Fails for a file that cannot be written.
    pub fn command(&mut self, command: &SessionCommand) -> io::Result<()> {
        self.put_idle()?;
        // The next step must be written in full, as the command belongs to it.
        self.last.clear();
        put_command(&mut self.block, command);
        self.put_block(COMMAND)
    }

    /// Writes the number of idle steps since the last step that was written.
    fn put_idle(&mut self) -> io::Result<()> {
        if self.idle == 0 {
            return Ok(());
        }
        self.block.extend_from_slice(&self.idle.to_le_bytes());
        self.idle = 0;
        self.put_block(IDLE)
    }

    /// The last block, followed by the digest of the file.
    fn end(&self) -> Vec<u8> {
        let mut digest = self.digest;
        let (head, content) = (block_head(END, size_of::<u64>()), self.steps.to_le_bytes());
        digest.bytes(&head);
        digest.bytes(&content);
        [&head[..], &content, &digest.value().to_le_bytes()].concat()
    }

    /// Writes `block` as a block of a kind, and clears it.
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

/// The first bytes of a block: its kind and its length (bytes).
fn block_head(kind: u8, length: usize) -> [u8; 5] {
    let mut head = [kind, 0, 0, 0, 0];
    head[1..].copy_from_slice(&(length as u32).to_le_bytes());
    head
}

/// Models, obstacles, fields and plugins of the session, with their digests.
fn files(inputs: &RecordingInputs<'_>) -> io::Result<Vec<RecordedFile>> {
    let RecordingInputs { scene, source, session, mesh, .. } = *inputs;
    let own = scene.body.iter().enumerate().filter_map(|(i, body)| {
        let path = source.folder().join(body.mesh.as_ref()?.get_ref());
        (i > 0 || mesh.is_none() || path.is_file()).then_some(path)
    });
    // Models first: a replay takes the first of these files for the model of the first body.
    let read = mesh.map(Path::to_path_buf).into_iter().chain(own);
    let read = read.chain(session.inputs.field_files.iter().chain(&session.inputs.obstacle_files).cloned());
    // Device plugins are not needed: limits and poses of devices are in the recording.
    let plugins = session.inputs.loaded.iter().filter(|l| l.kind != "device").map(|l| (PathBuf::from(&l.path), true));
    let all = plugins.chain(read.map(|path| (path, false)));
    all.map(|(path, plugin)| {
        let path = absolute(&path)?;
        let digest = Digest::of_file(&path).map_err(|e| error_at(&path, e))?;
        Ok(RecordedFile { path, digest, plugin })
    })
    .collect()
}

/// Whether a document is that of a file with these bytes, or that with its faces divided, which keeps the vertices of the file.
fn begins_with(document: &ObjDocument, bytes: &[u8]) -> bool {
    document.bytes() == bytes
        || ObjDocument::parse(bytes.to_vec(), document.name())
            .is_ok_and(|file| document.positions().starts_with(file.positions()))
}

/// The absolute form of a path; the error names the path.
fn absolute(path: &Path) -> io::Result<PathBuf> {
    std::path::absolute(path).map_err(|e| error_at(path, e))
}
