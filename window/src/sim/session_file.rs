//! The session as a file: what was done by hand, as a recording that `pliant replay` does again.
//!
//! Hands and commands of every step go to a file without a name from the start on; saving copies it. Beside the recording stands the model
//! as it was opened, for Save may have written over it since.

use crate::opening::Opened;
use pliant_engine::session::{Session, SessionCommand};
use pliant_record::{AtomicFile, Digest, RecordedFile, RecordingInputs, RecordingWriter, original_of};
use pliant_solver::Vec3;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// The recording of a session under way.
pub(super) struct SessionFile {
    /// Or why there is none.
    writer: Result<RecordingWriter<File>, String>,
    /// The model that was opened; `None` for a scene, whose models Save does not write over.
    model: Option<RecordedFile>,
}

impl SessionFile {
    /// Begins to record a session that has just been opened and keeps its history.
    pub(super) fn begin(opened: &Opened, is_model: bool) -> Self {
        let Opened { session, scene, source, mesh, .. } = opened;
        let mesh = mesh.as_deref();
        let inputs = RecordingInputs { scene, source, session, mesh, live: true, history: true };
        let writer = RecordingWriter::unnamed(&inputs).map_err(|error| error.to_string());
        let models = writer.iter().flat_map(|writer| writer.files()).filter(|file| !file.plugin);
        let model = models.cloned().next().filter(|_| is_model);
        Self { writer, model }
    }

    /// Records the step that the session has just taken, and the forces (N) its hands were given.
    pub(super) fn step(&mut self, session: &Session, device_forces: &[Vec3]) {
        self.write(|writer| writer.step(session, device_forces.iter().copied()));
    }

    /// Records a command and gives it to the session. Returns whether there was anything to do.
    pub(super) fn apply(&mut self, session: &mut Session, command: SessionCommand) -> bool {
        self.write(|writer| writer.command(command));
        session.apply(command)
    }

    fn write(&mut self, write: impl FnOnce(&mut RecordingWriter<File>) -> io::Result<()>) {
        if let Ok(writer) = &mut self.writer
            && let Err(error) = write(writer)
        {
            self.writer = Err(error.to_string());
        }
    }

    /// Writes the recording to `path`, and beside it the model as it was opened.
    ///
    /// # Errors
    /// A sentence on what cannot be written, or why the session could not be recorded.
    pub(super) fn save(&mut self, session: &Session, path: &Path) -> Result<(), String> {
        let writer = self.writer.as_mut().map_err(|why| format!("the session was not recorded: {why}"))?;
        if let (Some(recorded), Some(body)) = (&self.model, session.bodies.first()) {
            let bytes = body.model.document.bytes();
            if Digest::of(bytes) != recorded.digest {
                return Err(format!("{}: another program changed it while it was opened", recorded.path.display()));
            }
            let copy = || {
                let mut file = AtomicFile::create(&original_of(path))?;
                file.write_all(bytes)?;
                file.finish()
            };
            copy().map_err(|error| error.to_string())?;
        }
        writer.save_as(path).map_err(|error| error.to_string())
    }
}
