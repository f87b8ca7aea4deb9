//! From the text of a scene to an open session, as the program does it.

use super::failure::{Failure, contained};
use pliant_engine::plan::Plan;
use pliant_engine::scene::{self, Scene, Source};
use pliant_engine::session::{MAX_THREADS, Options, Session};
use pliant_host::{AllowedFolders, SearchPath};
use pliant_mesh::ObjDocument;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A scene from Python: its text, its path, and replacements of files and values.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct SceneText {
    /// Text of the scene, TOML.
    text: String,
    /// Path of the file, or its name in messages; paths in the scene are relative to its folder.
    path: PathBuf,
    /// OBJ texts that replace files, by the value of a body's `mesh`.
    documents: BTreeMap<String, String>,
    /// Factors of vertices that replace files, by the value of `csv` of a body's field.
    factors: BTreeMap<String, Vec<f64>>,
    /// Replaced values of the scene, each with its path, as `--set` takes them.
    set: Vec<(String, String)>,
}

/// How a session is opened.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct OpenOptions {
    /// Number of threads; 0 takes that of the machine.
    threads: usize,
    /// Folders that are searched for plugins first.
    plugin_path: Vec<PathBuf>,
    /// Folders from which scenes may name libraries by path.
    allow_plugins: Vec<PathBuf>,
    /// Folder of the plugins that come with the package.
    package_plugins: PathBuf,
    /// Another model in the place of the first body's.
    mesh: Option<PathBuf>,
    /// Devices whose hands the caller puts somewhere from the start.
    pub hands: Vec<String>,
    /// Whether edits can be undone.
    history: bool,
}

impl OpenOptions {
    /// The folders in which plugins are searched.
    pub fn search(&self) -> Result<SearchPath, Failure> {
        let allowed = AllowedFolders::new(&self.allow_plugins)?;
        Ok(SearchPath::in_package(&self.plugin_path, &self.package_plugins).allow(allowed))
    }
}

/// A scene and the session opened from it.
pub struct Opened {
    /// The parsed scene.
    pub scene: Scene,
    /// Its text and models.
    pub source: Source,
    /// The opened session.
    pub session: Session,
    /// The folders in which its plugins were searched.
    pub search: SearchPath,
}

/// Reads a scene with its models and factors of arrays.
pub fn load(given: SceneText) -> Result<(Scene, Source), Failure> {
    let (scene, mut source) = scene::load_text(&given.path, given.text, &given.set)?;
    for (name, text) in given.documents {
        let document = ObjDocument::parse(text.into_bytes(), Path::new(&name))?;
        source.documents.insert(name, document);
    }
    source.factors = given.factors;
    Ok((scene, source))
}

/// Refuses numbers of threads that no machine has.
fn check_threads(threads: usize) -> Result<(), Failure> {
    let text = || format!("threads is {threads}; allowed is 0 for what the machine has, to {MAX_THREADS}");
    if threads > MAX_THREADS { Err(Failure::argument(text())) } else { Ok(()) }
}

/// Opens a scene.
pub fn open(given: SceneText, options: &OpenOptions) -> Result<Opened, Failure> {
    let (scene, source) = load(given)?;
    let plan = Plan::new(&scene, &source)?;
    check_threads(options.threads)?;
    let (threads, mesh) = (options.threads, options.mesh.clone());
    let search = options.search()?;
    let opening = Options { mesh, ..Options::new(search.clone(), threads) };
    let mut session = Session::open(&scene, &source, plan, &opening)?;
    for tool in 0..session.tools.len() {
        if options.hands.contains(&session.devices[session.tools[tool].device].name) {
            session.place_hand(tool, None);
        }
    }
    if options.history {
        session.keep_history();
    }
    Ok(Opened { scene, source, session, search })
}

/// Reads and plans a scene without opening anything; raises what is wrong with it.
#[pyfunction]
pub fn check(py: Python<'_>, scene: SceneText) -> PyResult<()> {
    let done = py.detach(|| {
        contained(|| {
            let (scene, source) = load(scene)?;
            Plan::new(&scene, &source)?;
            Ok(())
        })
    });
    Ok(done?)
}
