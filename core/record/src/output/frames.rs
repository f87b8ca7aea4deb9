//! `frames/frame-NUMBER.obj`: the surfaces of all bodies at equal distances of simulated time.

use super::models::has_one_model;
use super::{BoxedOutput, FileNames, Output, OutputFolder, OutputKind};
use crate::atomic::error_at;
use crate::model::write_model_to;
use crate::result_set;
use pliant_engine::session::{Frame, Session, Warning};
use std::io;

/// Frames, if the scene asks for them: `frames/frame-NUMBER.obj`, or with several models `frames/frame-NAME-NUMBER.obj`.
pub(super) static FRAMES: OutputKind = OutputKind {
    names: FileNames::Many { folder: result_set::FRAMES, start: "frame", end: ".obj" },
    replaces: |_, _| Vec::new(),
    begin: |request| {
        let rate = request.scene.output.frames.as_ref().map(|rate| rate.get_ref().si);
        Ok(rate.map(|rate| Box::new(Frames { rate, next: 0 }) as BoxedOutput))
    },
};

/// Writes frames that are due.
struct Frames {
    /// Number of frames in a second of simulated time, 1/s.
    rate: f64,
    /// Number of the next frame.
    next: u64,
}

impl Frames {
    /// Number of frames due by the time of `frame`, with a margin for the rounding of the time.
    fn due(&self, frame: &Frame) -> u64 {
        (frame.time * self.rate * (1.0 + 1e-9)) as u64
    }
}

impl Output for Frames {
    fn needs_surface(&self, frame: &Frame) -> bool {
        self.due(frame) >= self.next
    }

    fn step(&mut self, session: &Session, folder: &OutputFolder) -> io::Result<()> {
        let due = self.due(session.frame());
        if due < self.next {
            return Ok(());
        }
        for body in &session.bodies {
            let name = if has_one_model(session) { String::new() } else { format!("-{}", body.name) };
            let name = format!("{}/frame{name}-{:05}.obj", result_set::FRAMES, self.next);
            let mut file = folder.create(&name)?;
            write_model_to(body, &session.plan().cap_material, &mut file)
                .map_err(|error| error_at(&folder.final_path(&name), error))?;
            file.finish()?;
        }
        self.next = due + 1;
        Ok(())
    }

    fn finish(self: Box<Self>, _session: &Session, _folder: &OutputFolder) -> io::Result<Option<Warning>> {
        Ok(None)
    }
}
