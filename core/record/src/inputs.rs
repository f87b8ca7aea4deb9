//! Inputs of a run: their digests for the summary.

use crate::content_hash::{hash_bytes, hash_file};
use pliant_engine::body::Model;
use pliant_engine::scene::Source;
use pliant_engine::session::Session;
use serde::Serialize;
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
        let (scene, text) = (shown(&source.path), source.text.to_string());
        let models: Vec<Arc<Model>> = models(session).map(Arc::clone).collect();
        let mut plugins: Vec<String> = session.inputs.loaded.iter().map(|l| l.path.clone()).collect();
        plugins.dedup();
        let obstacles = session.inputs.obstacle_files.clone();
        let fields = session.inputs.field_files.clone();
        let recordings: Vec<PathBuf> =
            session.inputs.recordings.iter().map(|hands| hands.path().to_path_buf()).collect();
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
pub(crate) fn models(session: &Session) -> impl Iterator<Item = &Arc<Model>> {
    session.bodies.iter().map(|body| &body.model).chain(session.standing.iter().map(|(_, model)| model))
}

/// A path as text; invalid UTF-8 is replaced.
pub(crate) fn shown(path: &Path) -> String {
    path.display().to_string()
}
