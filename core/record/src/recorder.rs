//! Recording a run from its first step to its last file.

use crate::atomic::{AtomicFile, AtomicFolder, error_at, remove_leftovers};
use crate::force_plot::write_force_plot;
use crate::model::write_model;
use crate::statistics::RunStatistics;
use crate::summary::Summary;
use crate::trace::{write_header, write_nodes, write_row};
use pliant_engine::scene::{OutputScene, Scene, Source};
use pliant_engine::session::Session;
use pliant_live::LiveSummary;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Records a run into a folder: trace and frames as it goes, the rest at its end.
pub struct Recorder {
    folder: PathBuf,
    output: OutputScene,
    trace: Option<AtomicFile>,
    frames: Option<AtomicFolder>,
    /// Begun first, so that a folder that cannot be written to is found before the run.
    summary: AtomicFile,
    statistics: RunStatistics,
    /// Number of the next frame.
    next_frame: u64,
    /// Timing and force safety of a live session, set by the caller before [`Recorder::finish`].
    pub live: Option<LiveSummary>,
}

impl Recorder {
    /// Begins recording into `folder`. `began` is when opening the scene began.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn new(scene: &Scene, source: &Source, session: &Session, folder: &Path, began: Instant) -> io::Result<Self> {
        let summary = AtomicFile::create(&folder.join("summary.json"))?;
        remove_leftovers(folder);
        let frames = scene.output.frames.as_ref().map(|_| AtomicFolder::create(&folder.join("frames"))).transpose()?;
        let mut trace = None;
        if scene.output.trace {
            let mut file = AtomicFile::create(&folder.join("trace.csv"))?;
            write_header(session, &mut file)?;
            trace = Some(file);
        }
        Ok(Self {
            folder: folder.to_path_buf(),
            output: scene.output.clone(),
            trace,
            frames,
            summary,
            statistics: RunStatistics::new(source, session, began),
            next_frame: 0,
            live: None,
        })
    }

    /// Records the step the session has just taken. `last`: no step comes after it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn step(&mut self, session: &mut Session, last: bool) -> io::Result<()> {
        let frame = session.frame();
        // Number of frames due by now, with a margin for the rounding of the time.
        let due = self.output.frames.as_ref().map(|f| (frame.time * f.get_ref().si * (1.0 + 1e-9)) as u64);
        let writes_frame = due.is_some_and(|due| due >= self.next_frame);
        self.statistics.step(session, last, writes_frame);
        if let Some(trace) = &mut self.trace {
            write_row(session.frame(), trace)?;
        }
        if let (true, Some(frames)) = (writes_frame, &self.frames) {
            let number = self.next_frame;
            self.write_models(session, frames.path(), &format!("-{number:05}"))?;
            self.next_frame = due.unwrap_or(number) + 1;
        }
        Ok(())
    }

    /// Gives every result its name and returns the summary, which is one of them. Results of an interrupted run go to `interrupted/` in
    /// the folder.
    ///
    /// # Errors
    /// A file that cannot be written; those already in place stay.
    pub fn finish(mut self, session: &mut Session, interrupted: bool) -> io::Result<Summary> {
        session.update_surface();
        // A run that was stopped must not replace the results of one that was finished.
        let folder = if interrupted { self.folder.join("interrupted") } else { self.folder.clone() };
        self.write_models(session, &folder, "")?;
        if let Some(trace) = self.trace.take() {
            trace.finish_as(&folder.join("trace.csv"))?;
        }
        if let Some(frames) = self.frames.take() {
            frames.finish_as(&folder.join("frames"))?;
        }
        if self.output.nodes {
            let mut file = AtomicFile::create(&folder.join("nodes.csv"))?;
            write_nodes(session, &mut file)?;
            file.finish()?;
        }
        if self.output.forces {
            let bodies = session.bodies.iter().enumerate().map(|(i, body)| (body, session.reactions(i)));
            write_force_plot(bodies, &folder.join("forces.svg"))?;
        }
        let summary = self.statistics.summary(session, self.live.take(), interrupted);
        let path = folder.join("summary.json");
        serde_json::to_writer_pretty(&mut self.summary, &summary).map_err(|e| error_at(&path, e.into()))?;
        writeln!(self.summary)?;
        self.summary.finish_as(&path)?;
        Ok(summary)
    }

    /// Writes the model of every body: `final.obj`, or with several bodies `final-NAME.obj`; frames have a `number` in their names.
    fn write_models(&self, session: &Session, folder: &Path, number: &str) -> io::Result<()> {
        let alone = session.bodies.len() + session.standing.len() == 1;
        let file = |name: &str| {
            let name = if alone { String::new() } else { format!("-{name}") };
            folder.join(if number.is_empty() { format!("final{name}.obj") } else { format!("frame{name}{number}.obj") })
        };
        for body in &session.bodies {
            write_model(body, &session.plan().cap_material, &file(&body.name))?;
        }
        for (name, model) in session.standing.iter().filter(|_| number.is_empty()) {
            let mut out = AtomicFile::create(&file(name))?;
            out.write_all(model.document.bytes())?;
            out.finish()?;
        }
        Ok(())
    }
}
