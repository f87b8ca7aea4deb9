//! From a scene file to an open session, as `run` and `plan` do it.

use crate::args::{Cli, SceneArgs};
use crate::outcome::Failure;
use crate::output::note_warnings;
use crate::run_end::strict_failure;
use crate::search::search_path;
use pliant_engine::plan::Plan;
use pliant_engine::scene::{self, Scene, Source};
use pliant_engine::session::{Options, Session};

/// A scene, its file and text, and the session opened from it.
pub struct OpenedScene {
    /// What the scene says.
    pub scene: Scene,
    /// Its file and text, for messages.
    pub source: Source,
    /// The opened session.
    pub session: Session,
}

/// Reads, plans and opens a scene.
pub fn open_scene(cli: &Cli, args: &SceneArgs) -> Result<OpenedScene, Failure> {
    let (scene, source) = scene::load(&args.scene, &args.set)?;
    let plan = Plan::new(&scene, &source)?;
    let search = search_path(cli)?;
    let options = Options {
        oversubscribe: args.oversubscribe,
        mesh: args.mesh.clone(),
        memory: args.memory.unwrap_or_default(),
        ..Options::new(search, args.threads)
    };
    let session = Session::open(&scene, &source, plan, &options)?;
    let warnings = session.warnings();
    note_warnings(&warnings);
    if args.strict && !warnings.is_empty() {
        return Err(strict_failure(&warnings));
    }
    Ok(OpenedScene { scene, source, session })
}
