//! Inputs of a run: their digests for the summary, and their protection against being overwritten.

use crate::atomic::{error_at, folder_of};
use crate::content_hash::{hash_bytes, hash_file};
use pliant_engine::body::Model;
use pliant_engine::scene::Source;
use pliant_engine::session::Session;
use serde::Serialize;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

/// An input of a run with its digest.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct InputHash {
    /// `program`, `scene`, `model`, `obstacle`, `field`, `recording` or `plugin`.
    pub role: &'static str,
    /// Path of the file, or kind of a generated shape.
    pub name: String,
    /// BLAKE3 digest, 64 hexadecimal digits; for a scene, of its text with `--set` applied. `None` if the file cannot be read.
    pub blake3: Option<String>,
}

/// Digests of the inputs of a run.
pub(crate) enum InputHashes {
    /// Computed on a thread of their own.
    OnThread(JoinHandle<Vec<InputHash>>),
    /// Computed at the end of the run, because the system gave no thread.
    AtEnd(Arc<dyn Fn() -> Vec<InputHash> + Send + Sync>),
}

impl InputHashes {
    /// Begins to compute the digests of the inputs of `session`.
    pub(crate) fn begin(source: &Source, session: &Session) -> Self {
        let (scene, text) = (shown(&source.path), source.text.clone());
        let models: Vec<Arc<Model>> = models(session).map(Arc::clone).collect();
        let mut plugins: Vec<String> = session.loaded.iter().map(|l| l.path.clone()).collect();
        plugins.dedup();
        let obstacles = session.obstacle_files.clone();
        let fields = session.field_files.clone();
        let recordings: Vec<PathBuf> = session.recordings.iter().map(|hands| hands.path().to_path_buf()).collect();
        let work = move || {
            let of_file = |role, path: &Path| InputHash { role, name: shown(path), blake3: hash_file(path).ok() };
            let of_bytes = |role, name, bytes: &[u8]| InputHash { role, name, blake3: Some(hash_bytes(bytes)) };
            let mut all: Vec<InputHash> =
                std::env::current_exe().iter().map(|program| of_file("program", program)).collect();
            all.push(of_bytes("scene", scene.clone(), text.as_bytes()));
            all.extend(models.iter().map(|m| match &m.tetrahedra {
                // The document is the boundary of the file, not the file.
                Some(cells) => of_file("model", cells.mesh().name()),
                None => of_bytes("model", shown(m.document.name()), m.document.bytes()),
            }));
            all.extend(obstacles.iter().map(|path| of_file("obstacle", path)));
            all.extend(fields.iter().map(|path| of_file("field", path)));
            all.extend(recordings.iter().map(|path| of_file("recording", path)));
            all.extend(plugins.iter().map(|path| of_file("plugin", Path::new(path))));
            all
        };
        let work = Arc::new(work);
        let on_thread = Arc::clone(&work);
        match std::thread::Builder::new().name("input hashes".into()).spawn(move || on_thread()) {
            Ok(thread) => Self::OnThread(thread),
            Err(_) => Self::AtEnd(work),
        }
    }

    /// Waits for the digests.
    pub(crate) fn finish(self) -> Vec<InputHash> {
        match self {
            Self::OnThread(thread) => thread.join().unwrap_or_default(),
            Self::AtEnd(work) => work(),
        }
    }
}

/// The models of a session, including those that are not simulated.
fn models(session: &Session) -> impl Iterator<Item = &Arc<Model>> {
    session.bodies.iter().map(|body| &body.model).chain(session.standing.iter().map(|(_, model)| model))
}

/// A path as text; invalid UTF-8 is replaced.
pub(crate) fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// Checks that no file of `outputs` is an input of the run: its scene, a model, an obstacle, a field, fibres, a recording or a plugin.
///
/// # Errors
/// Names the output and the kind of input.
pub(crate) fn refuse_inputs(
    outputs: impl Iterator<Item = PathBuf>,
    source: &Source,
    session: &Session,
) -> io::Result<()> {
    let files = models(session).map(|model| ("a model", model.document.name().to_path_buf()));
    let files = files.chain(session.loaded.iter().map(|l| ("a plugin", PathBuf::from(&l.path))));
    let files = files.chain(session.obstacle_files.iter().map(|path| ("an obstacle", path.clone())));
    let files = files
        .chain(session.field_files.iter().map(|path| ("a file of a field, of fibres or of a `fixed`", path.clone())));
    let files = files.chain(session.recordings.iter().map(|hands| ("a recording", hands.path().to_path_buf())));
    let inputs: Vec<(&str, PathBuf)> = files
        .chain([("the scene", source.path.clone())])
        .filter_map(|(what, path)| Some((what, path.canonicalize().ok()?)))
        .collect();
    for output in outputs {
        // The folder of an output may not exist yet.
        let Ok(folder) = folder_of(&output).canonicalize() else { continue };
        let path = folder.join(output.file_name().unwrap_or_default());
        let path = path.canonicalize().unwrap_or(path);
        if let Some((what, _)) = inputs.iter().find(|(_, input)| *input == path) {
            let text = format!("{what} of this run, which its results do not replace; choose another file or folder");
            return Err(error_at(&output, io::Error::new(ErrorKind::AlreadyExists, text)));
        }
    }
    Ok(())
}
