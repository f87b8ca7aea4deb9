//! From a scene file to an open session, the way every verb does it.

use crate::args::{Cli, SceneArgs};
use crate::outcome::Failure;
use pliant_engine::plan::Plan;
use pliant_engine::scene::{self, Scene, Source};
use pliant_engine::session::{Options, Session};
use pliant_host::SearchPath;

/// Reads, plans and opens.
pub fn open(cli: &Cli, args: &SceneArgs) -> Result<(Scene, Source, Session), Failure> {
    let (scene, source) = scene::load(&args.scene, &args.set)?;
    let plan = Plan::new(&scene, &source)?;
    let search = SearchPath::new(&cli.plugin_path);
    let options = Options { search, threads: args.threads, mesh: args.mesh.clone(), recorded: None };
    let session = Session::open(&scene, &source, plan, &options)?;
    Ok((scene, source, session))
}
