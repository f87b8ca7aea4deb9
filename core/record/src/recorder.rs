//! Recording of a run from its first step to its last file.

use crate::atomic::{AtomicFile, error_at};
use crate::inputs::InputHashes;
use crate::output::{BoxedOutput, OUTPUTS, OutputFolder, OutputRequest};
use crate::output_paths::RunOutputs;
use crate::result_set::{ResultSet, SUMMARY, files_below};
use crate::statistics::RunStatistics;
use crate::summary::Summary;
use pliant_engine::scene::{Scene, Source};
use pliant_engine::session::Session;
use pliant_live::LiveSummary;
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Instant;

/// Records a run into a folder: trace and frames during the run, the rest at its end. All results get their names at once.
pub struct Recorder {
    /// Folder of the results. Created before the run, so that a folder that cannot be written to is an error then.
    folder: OutputFolder,
    /// The outputs that the scene asks for.
    outputs: Vec<BoxedOutput>,
    /// Figures of the run.
    statistics: RunStatistics,
    /// Digests of the inputs; `None` if the system could not start their thread.
    hashes: Option<InputHashes>,
    /// Timing and force safety of a live session, set by the caller before [`Recorder::finish`].
    pub live: Option<LiveSummary>,
}

impl Recorder {
    /// Begins recording into the folder of `outputs` (or a folder, without a recording), after a check of all paths that the run writes. `began` is the time at which opening the
    /// scene began.
    ///
    /// # Errors
    /// Fails for a folder that cannot be written to, into which another run writes, or in which a result would replace an input of the run or a
    /// file that no run has written; and for a recording in the place of an input, of a result or of what is no regular file.
    pub fn new<'o>(
        scene: &Scene,
        source: &Source,
        session: &Session,
        outputs: impl Into<RunOutputs<'o>>,
        began: Instant,
    ) -> io::Result<Self> {
        let paths = outputs.into();
        let statistics = RunStatistics::new(source, session, began);
        let replaced = OUTPUTS.iter().flat_map(|kind| (kind.replaces)(session, paths.folder));
        paths.check(replaced.chain([SUMMARY.to_owned()]), source, session)?;
        let folder = OutputFolder { results: ResultSet::begin(paths.folder)?, folder: paths.folder.to_path_buf() };
        let request = OutputRequest { scene, source, session, folder: &folder };
        let hashes = Some(InputHashes::begin(source, session));
        let begun = OUTPUTS.iter().map(|kind| (kind.begin)(&request)).collect::<io::Result<Vec<_>>>()?;
        let outputs = begun.into_iter().flatten().collect();
        Ok(Self { folder, outputs, statistics, hashes, live: None })
    }

    /// Records the last step of the session. `last`: no step comes after it.
    ///
    /// # Errors
    /// Fails for a file that cannot be written.
    pub fn step(&mut self, session: &mut Session, last: bool) -> io::Result<()> {
        let needs_surface = self.outputs.iter().any(|output| output.needs_surface(session.frame()));
        self.statistics.step(session, last, needs_surface);
        self.outputs.iter_mut().try_for_each(|output| output.step(session, &self.folder))
    }

    /// Gives the results their names and returns the summary, which is one of them. Results of an interrupted run go to `interrupted/` in
    /// the folder, so that they do not replace those of a complete run.
    ///
    /// # Errors
    /// Fails for a file that cannot be written; the results of an earlier run are then unchanged.
    pub fn finish(mut self, session: &mut Session, interrupted: bool) -> io::Result<Summary> {
        session.update_surface();
        let mut warnings = Vec::new();
        for output in self.outputs {
            warnings.extend(output.finish(session, &self.folder)?);
        }
        let mut summary = self.statistics.summary(session, self.live, interrupted);
        summary.warnings.extend(warnings);
        let shown = |file: PathBuf| file.to_string_lossy().replace('\\', "/");
        summary.inputs = self.hashes.map(InputHashes::finish).unwrap_or_default();
        let OutputFolder { results, folder } = self.folder;
        summary.files = files_below(results.path())?.into_iter().map(shown).collect();
        results.flush()?;
        let mut file = AtomicFile::create_shown(&results.path().join(SUMMARY), &folder.join(SUMMARY))?;
        serde_json::to_writer_pretty(&mut file, &summary).map_err(|e| error_at(&folder.join(SUMMARY), e.into()))?;
        writeln!(file)?;
        file.finish()?;
        results.commit(interrupted)?;
        Ok(summary)
    }
}
