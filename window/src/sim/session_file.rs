//! The session as a file: what was done by hand, as a recording that `pliant replay` does again.
//!
//! Hands and commands of every step go to a file without a name from the start on; saving copies it. Beside the recording stands the model
//! as it was opened, for Save may have written over it since, and a scene that takes its hands from the recording, for `pliant run`.

use crate::opening::Opened;
use crate::strings;
use pliant_editor::SessionScene;
use pliant_engine::scene::Source;
use pliant_engine::session::{Session, SessionCommand};
use pliant_record::{AtomicFile, RecordingInputs, RecordingWriter, original_of};
use pliant_solver::Vec3;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A recording in a file without a name.
type Writer = RecordingWriter<BufWriter<File>>;

/// The recording of a session under way.
pub(super) struct SessionFile {
    /// Or why there is none.
    writer: Result<Writer, String>,
    source: Source,
    /// Model in the place of the scene's first.
    mesh: Option<PathBuf>,
    /// Whether a model was opened, which Save may write over, and not a scene.
    is_model: bool,
}

impl SessionFile {
    /// Begins to record a session that has just been opened and keeps its history.
    pub(super) fn begin(opened: &Opened, is_model: bool) -> Self {
        let Opened { session, scene, source, mesh, .. } = opened;
        let inputs = RecordingInputs { scene, source, session, mesh: mesh.as_deref(), live: true, history: true };
        let writer = RecordingWriter::unnamed(&inputs).map_err(|error| error.to_string());
        Self { writer, source: source.clone(), mesh: mesh.clone(), is_model }
    }

    /// Records the step that the session has just taken, and the forces (N) its hands were given.
    pub(super) fn step(&mut self, session: &Session, device_forces: &[Vec3]) {
        self.write(|writer| writer.step(session, device_forces.iter().copied()));
    }

    /// Records a command and gives it to the session. Returns whether there was anything to do.
    pub(super) fn apply(&mut self, session: &mut Session, command: SessionCommand) -> bool {
        self.write(|writer| writer.command(&command));
        session.apply(command)
    }

    fn write(&mut self, write: impl FnOnce(&mut Writer) -> io::Result<()>) {
        if let Ok(writer) = &mut self.writer
            && let Err(error) = write(writer)
        {
            self.writer = Err(error.to_string());
        }
    }

    /// Writes the recording to `path`, and beside it the model as it was opened and the scene, whose path is returned.
    ///
    /// # Errors
    /// A sentence on what cannot be written, or why the session could not be recorded.
    pub(super) fn save(&mut self, session: &Session, path: &Path) -> Result<PathBuf, String> {
        let writer = self.writer.as_mut().map_err(|why| strings::not_recorded(why))?;
        let scene_path = scene_of(path);
        if scene_path.canonicalize().is_ok_and(|path| self.source.path.canonicalize().is_ok_and(|open| open == path)) {
            return Err(strings::open_scene(&scene_path));
        }
        // The mesh of a scene may be a shape that is gone with the window.
        let with_model = self.is_model || self.mesh.is_some();
        writer.save_as(path, &self.source, session, with_model).map_err(|error| error.to_string())?;
        let original = original_of(path);
        let model = with_model.then_some(original.as_path());
        let scene = SessionScene { source: &self.source, session, model, recording: path };
        let named = |error: &dyn std::fmt::Display| format!("{}: {error}", scene_path.display());
        let absolute = std::path::absolute(&scene_path).map_err(|error| named(&error))?;
        let text = scene.to_toml(absolute.parent().unwrap_or(Path::new("/"))).map_err(|error| named(&error))?;
        let write = || {
            let mut file = AtomicFile::create_and_clean(&scene_path)?;
            file.write_all(text.as_bytes())?;
            file.finish()
        };
        write().map_err(|error: io::Error| error.to_string())?;
        Ok(scene_path)
    }
}

/// Path of the scene beside a recording: `NAME.session.toml` beside `NAME.rec`.
fn scene_of(recording: &Path) -> PathBuf {
    recording.with_extension("session.toml")
}
