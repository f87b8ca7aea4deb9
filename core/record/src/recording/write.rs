//! Writing a session down, step by step.

use super::super::atomic::{AtomicFile, with_path};
use super::bytes::{put_device, put_lapse, put_numbers, put_pose};
use super::{DEVICE, Digest, END, HEADER, Header, LAPSE, MAGIC, RecordedFile, STEP, VERSION, state_digest};
use pliant_engine::scene::{Scene, Source};
use pliant_engine::session::Session;
use pliant_host::Pose;
use pliant_solver::V3;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// One step of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedStep {
    /// Of each device, of each effector.
    pub poses: Vec<Vec<Pose>>,
    /// N, what each tool's effector was given last, in its device's axes
    pub given: Vec<V3>,
    /// Of the state after it.
    pub digest: u64,
}

/// A recording that is being made. It appears under its name when it is whole.
pub struct RecordingWriter {
    file: AtomicFile,
    block: Vec<u8>,
    digest: Digest,
    steps: u64,
    lapses: usize,
}

impl RecordingWriter {
    /// Begins a recording of a session that has just been opened.
    ///
    /// # Errors
    /// A file that cannot be written, or one of the scene's that cannot be read.
    pub fn create(
        path: &Path,
        (scene, source): (&Scene, &Source),
        session: &Session,
        mesh: Option<&Path>,
        live: bool,
    ) -> io::Result<Self> {
        let mut file = AtomicFile::create(path)?;
        let absolute = |path: &Path| std::path::absolute(path).map_err(|e| with_path(path, e));
        let header = Header {
            program: format!("pliant {}", env!("CARGO_PKG_VERSION")),
            scene: absolute(&source.path)?,
            text: source.text.clone(),
            mesh: mesh.map(absolute).transpose()?,
            live,
            files: files(scene, source, session, mesh)?,
        };
        let (mut start, mut digest) = (MAGIC.to_vec(), Digest::default());
        start.extend_from_slice(&VERSION.to_le_bytes());
        file.write_all(&start)?;
        digest.bytes(&start);
        let mut writer = Self { file, block: Vec::new(), digest, steps: 0, lapses: 0 };
        writer.block = serde_json::to_vec(&header)?;
        writer.put(HEADER)?;
        for slot in &session.devices {
            put_device(&mut writer.block, &slot.name, &slot.facts);
            writer.put(DEVICE)?;
        }
        Ok(writer)
    }

    /// Writes the step a session has just taken; `given` is what the hands were given while it was under way.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn step(&mut self, session: &Session, given: impl Iterator<Item = V3>) -> io::Result<()> {
        for lapse in &session.lapses()[self.lapses..] {
            put_lapse(&mut self.block, lapse);
            self.put(LAPSE)?;
        }
        self.lapses = session.lapses().len();
        for pose in session.devices.iter().flat_map(|slot| slot.poses()) {
            put_pose(&mut self.block, pose);
        }
        given.for_each(|force| put_numbers(&mut self.block, &force));
        self.block.extend_from_slice(&state_digest(session).to_le_bytes());
        self.steps += 1;
        self.put(STEP)
    }

    /// Ends it and puts it in its place.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.block.extend_from_slice(&self.steps.to_le_bytes());
        self.put(END)?;
        self.file.write_all(&self.digest.value().to_le_bytes())?;
        self.file.finish()
    }

    fn put(&mut self, kind: u8) -> io::Result<()> {
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

fn files(scene: &Scene, source: &Source, session: &Session, mesh: Option<&Path>) -> io::Result<Vec<RecordedFile>> {
    let own = scene.body.iter().enumerate().filter_map(|(i, body)| {
        let path = source.folder().join(body.mesh.as_ref()?.get_ref());
        (i > 0 || mesh.is_none() || path.is_file()).then_some(path)
    });
    let models: Vec<PathBuf> = own.chain(mesh.map(Path::to_path_buf)).collect();
    // Of a device only its limits and hands count, and those are in the recording.
    let plugins = session.loaded.iter().filter(|l| l.kind != "device").map(|l| (PathBuf::from(&l.path), true));
    let all = plugins.chain(models.into_iter().map(|path| (path, false)));
    all.map(|(path, plugin)| {
        let path = std::path::absolute(&path).map_err(|e| with_path(&path, e))?;
        let digest = Digest::of(&std::fs::read(&path).map_err(|e| with_path(&path, e))?);
        Ok(RecordedFile { path, digest, plugin })
    })
    .collect()
}
