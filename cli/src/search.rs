//! Where the verbs look for plugins.

use crate::args::Cli;
use crate::outcome::Failure;
use crate::output::note;
use pliant_host::{AllowedFolders, SearchPath};

/// The folders that are searched for plugins, with those of the command line. Notes the ones that are left out.
pub fn search_path(cli: &Cli) -> Result<SearchPath, Failure> {
    let allowed = AllowedFolders::new(&cli.allow_plugins).map_err(Failure::input)?;
    let search = SearchPath::new(&cli.plugin_path).allow(allowed);
    search.warnings().iter().for_each(|warning| note(&format!("warning: {warning}")));
    Ok(search)
}
