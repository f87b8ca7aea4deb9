//! Recording of a run from its first step to its last file.

use crate::atomic::{AtomicFile, error_at};
use crate::force_plot::write_force_plot;
use crate::inputs::InputHashes;
use crate::model::{write_model_to, write_tetrahedra_to};
use crate::outputs::RunOutputs;
use crate::parts::ModelParts;
use crate::result_set::{FRAMES, ResultSet, SUMMARY, files_below};
use crate::statistics::RunStatistics;
use crate::summary::Summary;
use crate::trace::{write_header, write_nodes, write_row};
use pliant_engine::body::{Body, Model};
use pliant_engine::scene::{OutputScene, PartsScene, Scene, Source};
use pliant_engine::session::{Session, Warning, WarningCode};
use pliant_live::LiveSummary;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Records a run into a folder: trace and frames during the run, the rest at its end. All results get their names at once.
pub struct Recorder {
    /// Files written so far, under temporary names. Created before the run, so that a folder that cannot be written to is an error then.
    results: ResultSet,
    /// Final folder of the results.
    folder: PathBuf,
    /// Files that the scene asks for.
    output: OutputScene,
    /// Where in the scene the parts of models are asked for as files.
    parts_asked_at: Option<String>,
    /// The trace, if the scene asks for it.
    trace: Option<AtomicFile>,
    /// Figures of the run.
    statistics: RunStatistics,
    /// Digests of the inputs; `None` if the system could not start their thread.
    hashes: Option<InputHashes>,
    /// Number of the next frame.
    next_frame: u64,
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
        let outputs = outputs.into();
        let folder = outputs.folder;
        let statistics = RunStatistics::new(source, session, began);
        let names = model_names(session).map(|(name, _)| name).chain(tetrahedra_names(session).map(|(name, _)| name));
        let names = names.chain(RESULTS.map(str::to_owned));
        outputs.check(names.chain(part_names(folder)), source, session)?;
        let parts = &scene.output.parts;
        let is_asked = *parts.get_ref() == PartsScene::Files;
        let results = ResultSet::begin(folder)?;
        let mut recorder = Self {
            results,
            folder: folder.to_path_buf(),
            output: scene.output.clone(),
            parts_asked_at: is_asked.then(|| source.error(parts.span(), "").place()),
            trace: None,
            statistics,
            hashes: Some(InputHashes::begin(source, session)),
            next_frame: 0,
            live: None,
        };
        if scene.output.trace {
            let mut file = recorder.create("trace.csv")?;
            write_header(session, &mut file)?;
            recorder.trace = Some(file);
        }
        Ok(recorder)
    }

    /// Begins a file of the results, by its path in the folder, to be flushed to the disk with the others.
    fn create(&self, name: &str) -> io::Result<AtomicFile> {
        AtomicFile::create_staged(&self.results.path().join(name), &self.folder.join(name))
    }

    /// Records the last step of the session. `last`: no step comes after it.
    ///
    /// # Errors
    /// Fails for a file that cannot be written.
    pub fn step(&mut self, session: &mut Session, last: bool) -> io::Result<()> {
        let frame = session.frame();
        // Number of frames due by now, with a margin for the rounding of the time.
        let due = self.output.frames.as_ref().map(|f| (frame.time * f.get_ref().si * (1.0 + 1e-9)) as u64);
        let writes_frame = due.is_some_and(|due| due >= self.next_frame);
        self.statistics.step(session, last, writes_frame);
        if let Some(trace) = &mut self.trace {
            write_row(session.frame(), trace)?;
        }
        if writes_frame {
            let number = self.next_frame;
            self.write_frame(session, number)?;
            self.next_frame = due.unwrap_or(number) + 1;
        }
        Ok(())
    }

    /// Gives the results their names and returns the summary, which is one of them. Results of an interrupted run go to `interrupted/` in
    /// the folder, so that they do not replace those of a complete run.
    ///
    /// # Errors
    /// Fails for a file that cannot be written; the results of an earlier run are then unchanged.
    pub fn finish(mut self, session: &mut Session, interrupted: bool) -> io::Result<Summary> {
        session.update_surface();
        for (name, document) in model_names(session) {
            let mut file = self.create(&name)?;
            match document {
                ModelSource::Body(body) => write_model_to(body, &session.plan().cap_material, &mut file)
                    .map_err(|error| error_at(&self.folder.join(name), error))?,
                ModelSource::Standing(model) => file.write_all(model.document.bytes())?,
            }
            file.finish()?;
        }
        for (name, body) in tetrahedra_names(session) {
            let mut file = self.create(&name)?;
            write_tetrahedra_to(body, &mut file).map_err(|error| error_at(&self.folder.join(name), error))?;
            file.finish()?;
        }
        let one_part = self.write_parts(session)?;
        self.trace.take().map(AtomicFile::finish).transpose()?;
        if self.output.nodes {
            let mut file = self.create("nodes.csv")?;
            write_nodes(session, &mut file)?;
            file.finish()?;
        }
        if self.output.forces {
            let bodies = session.bodies.iter().enumerate().map(|(i, body)| (body, session.reactions(i)));
            let mut file = self.create("forces.svg")?;
            write_force_plot(bodies, &mut file)?;
            file.finish()?;
        }
        let mut summary = self.statistics.summary(session, self.live.take(), interrupted);
        summary.warnings.extend(one_part);
        let shown = |file: PathBuf| file.to_string_lossy().replace('\\', "/");
        summary.inputs = self.hashes.take().map(InputHashes::finish).unwrap_or_default();
        summary.files = files_below(self.results.path())?.into_iter().map(shown).collect();
        self.results.flush()?;
        let mut file = AtomicFile::create_shown(&self.results.path().join(SUMMARY), &self.folder.join(SUMMARY))?;
        serde_json::to_writer_pretty(&mut file, &summary)
            .map_err(|e| error_at(&self.folder.join(SUMMARY), e.into()))?;
        writeln!(file)?;
        file.finish()?;
        self.results.commit(interrupted)?;
        Ok(summary)
    }

    /// Writes the parts of every body that is in several, if they are asked for; otherwise gives a warning if all are in one.
    fn write_parts(&self, session: &Session) -> io::Result<Option<Warning>> {
        let Some(place) = &self.parts_asked_at else { return Ok(None) };
        let mut is_split = false;
        for (name, source) in model_names(session) {
            let ModelSource::Body(body) = source else { continue };
            let shown = self.folder.join(&name);
            let parts =
                ModelParts::of(body, &session.plan().cap_material, &shown).map_err(|error| error_at(&shown, error))?;
            for part in (0..parts.count()).filter(|_| parts.count() > 1) {
                is_split = true;
                let mut file = self.create(&format!("{}{PART}{}.obj", name.trim_end_matches(".obj"), part + 1))?;
                parts.write(part, &mut file)?;
                file.finish()?;
            }
        }
        let message = "`parts = \"files\"`, and every model is in one part: there are no files of parts; cut through a model, or leave it out";
        let warning = || Warning { code: WarningCode::OnePart, place: place.clone(), message: message.into() };
        Ok((!is_split).then(warning))
    }

    /// Writes a frame of every body: `frames/frame-NUMBER.obj`, or with several bodies `frames/frame-NAME-NUMBER.obj`.
    /// Writes a frame of every body: `frames/frame-NUMBER.obj`, or with several models `frames/frame-NAME-NUMBER.obj`.
    fn write_frame(&self, session: &Session, number: u64) -> io::Result<()> {
        for body in &session.bodies {
            let name = if has_one_model(session) { String::new() } else { format!("-{}", body.name) };
            let name = format!("{FRAMES}/frame{name}-{number:05}.obj");
            let mut file = self.create(&name)?;
            write_model_to(body, &session.plan().cap_material, &mut file)
                .map_err(|error| error_at(&self.folder.join(name), error))?;
            file.finish()?;
        }
        Ok(())
    }
}

/// Names of results besides the models and frames.
const RESULTS: [&str; 4] = ["trace.csv", "nodes.csv", "forces.svg", SUMMARY];

/// What stands between the name of a model and the number of its part.
const PART: &str = "-part-";

/// Names of files of parts in a folder, from a run before.
fn part_names(folder: &Path) -> impl Iterator<Item = String> {
    let names =
        std::fs::read_dir(folder).into_iter().flatten().filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.filter(|name| name.starts_with("final") && name.contains(PART))
}

/// Content of the file of a model.
enum ModelSource<'a> {
    /// A body with its deformed surface.
    Body(&'a Body),
    /// A model that is not simulated.
    Standing(&'a Model),
}

/// Whether the session has a single model.
fn has_one_model(session: &Session) -> bool {
    session.bodies.len() + session.standing.len() == 1
}

/// The file name of each model, `final.obj` or with several models `final-NAME.obj`, and its content.
fn model_names(session: &Session) -> impl Iterator<Item = (String, ModelSource<'_>)> {
    let has_one = has_one_model(session);
    let file = move |name: &str| if has_one { "final.obj".to_owned() } else { format!("final-{name}.obj") };
    let bodies = session.bodies.iter().map(move |body| (file(&body.name), ModelSource::Body(body)));
    let standing = session.standing.iter();
    bodies.chain(standing.map(move |(name, model)| (file(name), ModelSource::Standing(model))))
}

/// The file name of each tetrahedral mesh, `final.vtk` or with several models `final-NAME.vtk`, and its body.
fn tetrahedra_names(session: &Session) -> impl Iterator<Item = (String, &Body)> {
    model_names(session).filter_map(|(name, source)| match source {
        ModelSource::Body(body) if body.model.tetrahedra.is_some() => {
            Some((format!("{}.vtk", name.trim_end_matches(".obj")), body))
        }
        ModelSource::Body(_) | ModelSource::Standing(_) => None,
    })
}
