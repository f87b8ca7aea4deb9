//! Files that a run writes: one file here for each kind.
//!
//! A kind says which names its files have and how it begins; what it has begun follows the run. A new kind is added by its file, its line in
//! [`OUTPUTS`] and, if a scene asks for it, a key of `OutputScene`.

mod force_plot;
mod frames;
mod models;
mod nodes;
mod part_files;
mod tetrahedra;
mod trace;

pub use trace::{TracedTool, trace_cells, trace_columns, traced_tools};

use crate::atomic::AtomicFile;
use crate::result_set::ResultSet;
use pliant_engine::scene::{Scene, Source};
use pliant_engine::session::{Frame, Session, Warning};
use std::io;
use std::path::{Path, PathBuf};

/// Every kind of file that a run writes beside its summary, in the order in which they are finished.
pub(crate) static OUTPUTS: &[&OutputKind] = &[
    &models::MODELS,
    &tetrahedra::TETRAHEDRA,
    &part_files::PARTS,
    &trace::TRACE,
    &nodes::NODES,
    &force_plot::FORCES,
    &frames::FRAMES,
];

/// A kind of file that a run writes.
pub(crate) struct OutputKind {
    /// Names of its files.
    pub(crate) names: FileNames,
    /// Those of its files, by their paths in the folder of results, that a run of a session may replace and that are not to be an input of it.
    pub(crate) replaces: fn(&Session, &Path) -> Vec<String>,
    /// Begins it; `None` for a scene that does not ask for it.
    pub(crate) begin: fn(&OutputRequest<'_>) -> io::Result<Option<BoxedOutput>>,
}

/// Names of the files of a kind.
pub(crate) enum FileNames {
    /// One file of this name.
    One(&'static str),
    /// Files in a folder of the results whose names begin and end so.
    Many {
        /// The folder; empty for that of the results.
        folder: &'static str,
        /// Beginning of each name.
        start: &'static str,
        /// End of each name.
        end: &'static str,
    },
}

impl FileNames {
    /// Whether a path in the folder of results is one of them.
    pub(crate) fn contains(&self, path: &Path) -> bool {
        let (Some(folder), Some(name)) = (path.parent(), path.file_name().and_then(|name| name.to_str())) else {
            return false;
        };
        match *self {
            Self::One(only) => folder == Path::new("") && name == only,
            Self::Many { folder: own, start, end } => {
                folder == Path::new(own) && name.starts_with(start) && name.ends_with(end)
            }
        }
    }
}

/// A run that begins.
pub(crate) struct OutputRequest<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) source: &'a Source,
    pub(crate) session: &'a Session,
    pub(crate) folder: &'a OutputFolder,
}

/// An output of a run that is under way.
pub(crate) trait Output: Send + Sync {
    /// Whether it needs the surfaces of bodies after the step of `frame`.
    fn needs_surface(&self, _frame: &Frame) -> bool {
        false
    }

    /// Records the last step of the session.
    ///
    /// # Errors
    /// Fails for a file that cannot be written.
    fn step(&mut self, _session: &Session, _folder: &OutputFolder) -> io::Result<()> {
        Ok(())
    }

    /// Writes what is written at the end of the run, when all surfaces are up to date. Returns a warning if it had nothing to write that the scene asks for.
    ///
    /// # Errors
    /// Fails for a file that cannot be written.
    fn finish(self: Box<Self>, session: &Session, folder: &OutputFolder) -> io::Result<Option<Warning>>;
}

/// An output that was begun.
pub(crate) type BoxedOutput = Box<dyn Output>;

/// The folder of a run's results, whose files do not have their names yet.
pub(crate) struct OutputFolder {
    /// Files written so far, under temporary names.
    pub(crate) results: ResultSet,
    /// Final folder of the results.
    pub(crate) folder: PathBuf,
}

impl OutputFolder {
    /// Begins a file of the results, by its path in the folder, to be flushed to the disk with the others.
    ///
    /// # Errors
    /// Fails for a file that cannot be written.
    pub(crate) fn create(&self, name: &str) -> io::Result<AtomicFile> {
        AtomicFile::create_staged(&self.results.path().join(name), &self.final_path(name))
    }

    /// The path that a file of the results will have, for messages.
    pub(crate) fn final_path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }
}
