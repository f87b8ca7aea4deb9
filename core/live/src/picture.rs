//! What a viewer is shown: sixty times a second, if it keeps up.

use pliant_engine::session::{Session, ToolFrame};
use pliant_solver::V3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle, sleep};
use std::time::Duration;
use triple_buffer::{Input, Output, triple_buffer};

/// A moment of a session.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// s, of the session
    pub time: f64,
    /// m, vertices of the surface of each body that moves (n x 3)
    pub surfaces: Vec<Vec<V3>>,
    /// In order.
    pub tools: Vec<ToolFrame>,
}

/// Somebody who looks. It has a thread of its own and sees whole pictures; those it is too slow for, it does not see.
pub trait Viewer: Send {
    /// A new picture.
    fn show(&mut self, picture: &Picture);
}

/// ns between two pictures
const APART: u64 = 1_000_000_000 / 60;

/// The simulation's end.
pub(super) struct Display {
    pictures: Input<Picture>,
    due: u64,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Display {
    pub(super) fn start(viewer: Box<dyn Viewer>) -> std::io::Result<Self> {
        let (pictures, output) = triple_buffer(&Picture::default());
        let stop = Arc::new(AtomicBool::new(false));
        let of_thread = Arc::clone(&stop);
        let look = move || look(viewer, output, &of_thread);
        let thread = Some(Builder::new().name("display".into()).spawn(look)?);
        Ok(Self { pictures, due: 0, stop, thread })
    }

    /// Makes a picture if one is due at `now` (ns).
    pub(super) fn take(&mut self, session: &mut Session, now: u64) {
        if now < self.due {
            return;
        }
        self.due = now + APART;
        session.update_surface();
        let picture = self.pictures.input_buffer_mut();
        picture.time = session.time();
        picture.surfaces.resize_with(session.bodies.len(), Vec::new);
        for (surface, body) in picture.surfaces.iter_mut().zip(&session.bodies) {
            surface.clear();
            surface.extend_from_slice(&body.skin.x);
        }
        picture.tools.clear();
        picture.tools.extend_from_slice(&session.frame().tools);
        self.pictures.publish();
    }
}

fn look(mut viewer: Box<dyn Viewer>, mut pictures: Output<Picture>, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        if pictures.update() {
            viewer.show(pictures.output_buffer_mut());
        }
        sleep(Duration::from_nanos(APART / 4));
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
