//! Autosave: after each stroke that has changed something the shape is written beside the user's other state, so that a crash loses the stroke
//! under way and no more. It is written when nothing has happened for a second, or when the next stroke begins; only where strokes follow each
//! other faster than the file system writes, some are written together. A thread of its own writes it, unless the model was cut.
//!
//! Each session has a folder with a file that it keeps locked; a folder whose lock is free belongs to a session that has ended
//! without closing, and its shape is offered at the next start. The model file itself is written by Save alone.

use super::export::write_together;
use super::shape_copy::ShapeCopy;
use crate::opening::OpenRequest;
use crate::strings;
use pliant_editor::{LengthUnit, SOLIDS, SolidPreset, Substance};
use pliant_engine::session::Session;
use pliant_mesh::ObjDocument;
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread::{Builder, JoinHandle};

/// s, after the end of a stroke before the shape is written: it has come to rest, and another stroke may have begun
const IDLE: f64 = 1.0;

/// Sessions this program has begun, for names of folders.
static SESSIONS: AtomicU32 = AtomicU32::new(0);

/// The autosave of a session.
pub(super) struct Autosave {
    note: Note,
    /// The folder of all sessions.
    states: Option<PathBuf>,
    /// The one of this session, and the file it keeps locked, once there was something to write.
    folder: Option<PathBuf>,
    lock: Option<File>,
    /// Whether there is something to write.
    is_pending: bool,
    /// s, when there was last something to write
    since: f64,
    /// Whether a stroke is under way.
    is_busy: bool,
    /// The thread that writes.
    writing: Option<JoinHandle<Result<(), String>>>,
    /// Text of the model's file, for copies of the shape.
    document: Option<Arc<ObjDocument>>,
}

/// What is noted beside a shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Note {
    /// The model or scene as the user knows it.
    path: PathBuf,
    unit: Option<LengthUnit>,
    /// What it was made of; `None` in notes of older programs.
    #[serde(default)]
    material: Option<NotedMaterial>,
}

/// What a model was made of when it was opened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct NotedMaterial {
    substance: Option<Substance>,
    subdivide: bool,
    #[serde(default)]
    weld: Option<bool>,
    /// Name of the preset, and the numbers that may differ from it: Pa, kg/m^3 and s.
    preset: String,
    young: f64,
    density: f64,
    damping_time: f64,
    plugin: String,
    fabric: String,
    level: u32,
}

impl NotedMaterial {
    fn of(request: &OpenRequest) -> Self {
        let SolidPreset { name, young, density, damping_time, .. } = request.solid;
        Self {
            substance: request.substance,
            subdivide: request.subdivide,
            weld: request.weld,
            preset: name.to_owned(),
            young,
            density,
            damping_time,
            plugin: request.solid_plugin.clone(),
            fabric: request.fabric.clone(),
            level: request.level,
        }
    }

    /// Asks for this material in a request.
    fn give(&self, request: &mut OpenRequest) {
        if let Some(preset) = SOLIDS.iter().find(|preset| preset.name == self.preset) {
            let (young, density, damping_time) = (self.young, self.density, self.damping_time);
            request.solid = SolidPreset { young, density, damping_time, ..*preset };
        }
        (request.substance, request.subdivide, request.level) = (self.substance, self.subdivide, self.level);
        request.weld = self.weld;
        (request.solid_plugin, request.fabric) = (self.plugin.clone(), self.fabric.clone());
    }
}

/// The shape of a session that has ended without closing.
#[derive(Clone, Debug, PartialEq)]
pub struct Abandoned {
    folder: PathBuf,
    note: Note,
}

impl Autosave {
    pub(super) fn new(request: &OpenRequest) -> Self {
        let path = std::path::absolute(&request.path).unwrap_or_else(|_| request.path.clone());
        let note = Note { path, unit: request.unit, material: Some(NotedMaterial::of(request)) };
        // A shape that is not the one of the file is written at once.
        let states = request.autosave.clone().or_else(state_folder);
        Self {
            note,
            states,
            folder: None,
            lock: None,
            is_pending: request.shape.is_some(),
            since: 0.0,
            is_busy: false,
            writing: None,
            document: None,
        }
    }

    /// There is something to write, at `now` (s).
    pub(super) fn need(&mut self, now: f64) {
        (self.is_pending, self.since) = (true, now);
    }

    /// A stroke begins: what is to be written waits for its end. Returns whether the shape must be written before it, so that it is not lost with this stroke.
    #[must_use]
    pub(super) fn begin_stroke(&mut self) -> bool {
        let is_first = !std::mem::replace(&mut self.is_busy, true);
        is_first && self.is_pending && self.is_free()
    }

    /// The stroke has ended, at `now` (s).
    pub(super) fn end_stroke(&mut self, now: f64) {
        (self.is_busy, self.since) = (false, now);
    }

    /// Whether it is time to write.
    pub(super) fn is_due(&self, now: f64) -> bool {
        self.is_free() && self.is_pending && !self.is_busy && now >= self.since + IDLE
    }

    /// Whether nothing is being written.
    fn is_free(&self) -> bool {
        self.writing.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Writes the shape: a copy of it on a thread of its own, or, after a cut, at once.
    ///
    /// # Errors
    /// A sentence on what the file system says, or said the last time.
    pub(super) fn save(&mut self, session: &Session, cap_material: &str) -> Result<(), String> {
        let before = self.wait();
        self.is_pending = false;
        let failed = |error: std::io::Error| strings::autosave_problem(&error);
        let folder = self.folder().map_err(failed)?;
        let note = serde_json::to_vec_pretty(&self.note).map_err(|error| strings::autosave_problem(&error))?;
        let write_note = move |folder: &Path| fs::write(folder.join(NOTE), &note).map_err(failed);
        match ShapeCopy::take(session, self.document.as_ref()) {
            Some(copy) => {
                self.document = Some(Arc::clone(copy.document()));
                let work = Arc::new(move || {
                    copy.write(&folder.join(SHAPE)).map_err(failed)?;
                    write_note(&folder)
                });
                let on_thread = Arc::clone(&work);
                match Builder::new().name("autosave".into()).spawn(move || on_thread()) {
                    Ok(thread) => self.writing = Some(thread),
                    // Without a thread it is written here.
                    Err(_) => work()?,
                }
            }
            None => {
                write_together(session, cap_material, &folder.join(SHAPE)).map_err(failed)?;
                write_note(&folder)?;
            }
        }
        before
    }

    /// What went wrong in a write that has ended since the last call; `Ok` also while one is under way.
    ///
    /// # Errors
    /// A sentence on what the file system says.
    pub(super) fn poll(&mut self) -> Result<(), String> {
        if self.writing.as_ref().is_some_and(JoinHandle::is_finished) { self.wait() } else { Ok(()) }
    }

    /// Waits until what is being written is there; gives what went wrong.
    fn wait(&mut self) -> Result<(), String> {
        let gone = |_| Err(strings::AUTOSAVE_FAILED.to_owned());
        self.writing.take().map_or(Ok(()), |thread| thread.join().unwrap_or_else(gone))
    }

    /// The folder of the session, made and locked when it is first needed.
    fn folder(&mut self) -> std::io::Result<PathBuf> {
        if let Some(folder) = &self.folder {
            return Ok(folder.clone());
        }
        let name = format!("{}-{}", std::process::id(), SESSIONS.fetch_add(1, Ordering::Relaxed));
        let folder = self.states.as_ref().ok_or_else(|| std::io::Error::other(strings::NO_HOME))?.join(name);
        fs::create_dir_all(&folder)?;
        let lock = File::create(folder.join(LOCK))?;
        // A file system that knows no locks is no reason not to write.
        let _ = lock.try_lock();
        (self.lock, self.folder) = (Some(lock), Some(folder.clone()));
        Ok(folder)
    }

    /// Removes what was written: the session ends as it should.
    pub(super) fn discard(&mut self) {
        // What could not be written need not be removed.
        let _ = self.wait();
        self.lock = None;
        if let Some(folder) = self.folder.take() {
            let _ = fs::remove_dir_all(folder);
        }
    }
}

/// Names of the files in a session's folder.
const SHAPE: &str = "shape.obj";
const NOTE: &str = "session.json";
const LOCK: &str = "lock";

/// The folder of all sessions: `$XDG_STATE_HOME/pliant/autosave`, or where the system keeps such things; `None` without a home folder.
pub fn state_folder() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let state =
        set("XDG_STATE_HOME").or_else(|| set("LOCALAPPDATA")).or_else(|| Some(set("HOME")?.join(".local/state")));
    Some(state?.join("pliant").join("autosave"))
}

/// Shapes of sessions that have ended without closing, the newest first, in the folder of all sessions or the usual one.
pub fn abandoned(states: Option<&Path>) -> Vec<Abandoned> {
    let states = states.map(Path::to_path_buf).or_else(state_folder);
    states.map(|folder| abandoned_in(&folder)).unwrap_or_default()
}

fn abandoned_in(folder: &Path) -> Vec<Abandoned> {
    let folders = fs::read_dir(folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let mut found: Vec<_> = folders.filter_map(|folder| Some((modified(&folder)?, read(folder)?))).collect();
    found.sort_by_key(|(time, _)| std::cmp::Reverse(*time));
    found.into_iter().map(|(_, abandoned)| abandoned).collect()
}

fn modified(folder: &Path) -> Option<std::time::SystemTime> {
    fs::metadata(folder.join(SHAPE)).ok()?.modified().ok()
}

/// The session of a folder, if it has ended.
fn read(folder: PathBuf) -> Option<Abandoned> {
    File::open(folder.join(LOCK)).ok()?.try_lock().ok()?;
    let note = serde_json::from_slice(&fs::read(folder.join(NOTE)).ok()?).ok()?;
    Some(Abandoned { folder, note })
}

impl Abandoned {
    /// The model or scene it was made of.
    pub fn path(&self) -> &Path {
        &self.note.path
    }

    /// Opens the shape in the place of what is asked for in `like`. The shape is in the folder of the session until it is discarded.
    pub fn request(&self, like: &OpenRequest) -> OpenRequest {
        let shape = Some(self.folder.join(SHAPE));
        let mut request =
            OpenRequest { path: self.note.path.clone(), unit: self.note.unit, substance: None, shape, ..like.clone() };
        if let Some(material) = &self.note.material {
            material.give(&mut request);
        }
        request
    }

    /// Removes the shape and its note: they are saved or not wanted.
    pub fn discard(self) {
        let _ = fs::remove_dir_all(self.folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_whose_lock_is_free_belongs_to_a_session_that_has_ended() {
        let states = tempfile::tempdir().unwrap();
        let folder = states.path().join("1-0");
        fs::create_dir_all(&folder).unwrap();
        let mut opened =
            OpenRequest { substance: Some(Substance::Solid), level: 5, ..OpenRequest::new(PathBuf::new()) };
        opened.solid = SolidPreset { young: 7e3, ..SOLIDS[3] };
        let material = Some(NotedMaterial::of(&opened));
        let note = Note { path: "/models/a.obj".into(), unit: Some(LengthUnit::Millimetre), material };
        fs::write(folder.join(NOTE), serde_json::to_vec(&note).unwrap()).unwrap();
        fs::write(folder.join(SHAPE), "v 0 0 0\n").unwrap();
        let lock = File::create(folder.join(LOCK)).unwrap();
        lock.try_lock().unwrap();
        assert_eq!(abandoned_in(states.path()), [], "a session that goes on");
        drop(lock);
        let found = abandoned_in(states.path()).pop().expect("one that has ended");
        let request = found.request(&OpenRequest::new(PathBuf::new()));
        assert_eq!((request.solid, request.level, request.substance), (opened.solid, 5, opened.substance));
        assert_eq!((request.path, request.shape), ("/models/a.obj".into(), Some(folder.join(SHAPE))));
        found.discard();
        assert_eq!(abandoned_in(states.path()), []);
    }

    #[test]
    fn a_shape_is_written_once_after_a_stroke_and_not_during_one() {
        let mut autosave = Autosave::new(&OpenRequest::new("a.obj".into()));
        assert!(!autosave.is_due(100.0));
        autosave.need(1.0);
        assert!(!autosave.is_due(1.5) && autosave.is_due(2.0));
        assert!(autosave.begin_stroke(), "the shape before this stroke would be lost with it");
        assert!(!autosave.begin_stroke(), "a mirrored hand begins no other stroke");
        autosave.need(3.0);
        assert!(!autosave.is_due(50.0));
        autosave.end_stroke(50.0);
        assert!(!autosave.is_due(50.5) && autosave.is_due(51.0));
        autosave.is_pending = false;
        assert!(!autosave.begin_stroke(), "there is nothing to write");
    }
}
