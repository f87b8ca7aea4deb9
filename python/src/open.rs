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

/// A scene as Python hands it over: its text, where that stands, and what replaces parts of it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct SceneText {
    /// TOML.
    text: String,
    /// The file, or what messages call it; paths in the scene are relative to its folder.
    path: PathBuf,
    /// OBJ texts by the name that a body's `mesh` gives.
    documents: BTreeMap<String, String>,
    /// Factors of vertices by the name that the `csv` of a body's field gives.
    factors: BTreeMap<String, Vec<f64>>,
    /// Values by their path in the scene.
    set: Vec<(String, String)>,
}

/// How a session is opened.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct OpenOptions {
    /// Threads; 0 takes what the machine has.
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
    /// Whether edits can be taken back.
    history: bool,
}

impl OpenOptions {
    /// Where plugins are looked for.
    pub fn search(&self) -> Result<SearchPath, Failure> {
        let allowed = AllowedFolders::new(&self.allow_plugins)?;
        Ok(SearchPath::in_package(&self.plugin_path, &self.package_plugins).allow(allowed))
    }
}

/// A scene and the session opened from it.
pub struct Opened {
    /// What the scene says.
    pub scene: Scene,
    /// Its text and models.
    pub source: Source,
    /// The opened session.
    pub session: Session,
    /// Where its plugins were looked for.
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
