//! A viewer on its own thread, shown a frame sixty times a second if it keeps up.

use pliant_engine::session::{Session, ToolFrame};
use pliant_solver::Vec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle, sleep};
use std::time::Duration;
use triple_buffer::{Input, Output, triple_buffer};

/// Surfaces and tools of a session at one time.
#[derive(Clone, Debug, Default)]
pub struct ViewFrame {
    /// s, simulated time
    pub time: f64,
    /// m (n x 3), deformed vertices of the surface of each simulated body
    pub surfaces: Vec<Vec<Vec3>>,
    /// The tools in the order of the session.
    pub tools: Vec<ToolFrame>,
}

/// Receives frames on its own thread; frames it is too slow for are dropped.
pub trait Viewer: Send {
    /// Shows a new frame.
    fn show(&mut self, frame: &ViewFrame);
}

/// ns between two frames
const FRAME_PERIOD: u64 = 1_000_000_000 / 60;

/// The simulation's end of a viewer. Dropping it ends the thread.
pub(crate) struct ViewerThread {
    frames: Input<ViewFrame>,
    /// ns, time of the next frame
    due: u64,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl ViewerThread {
    /// Starts the thread of a viewer.
    pub(crate) fn start(viewer: Box<dyn Viewer>) -> std::io::Result<Self> {
        let (frames, output) = triple_buffer(&ViewFrame::default());
        let stop = Arc::new(AtomicBool::new(false));
        let of_thread = Arc::clone(&stop);
        let show = move || show_frames(viewer, output, &of_thread);
        let thread = Some(Builder::new().name("viewer".into()).spawn(show)?);
        Ok(Self { frames, due: 0, stop, thread })
    }

    /// Publishes a frame of the session if one is due at `now` (ns).
    pub(crate) fn publish(&mut self, session: &mut Session, now: u64) {
        if now < self.due {
            return;
        }
        self.due = now + FRAME_PERIOD;
        session.update_surface();
        let frame = self.frames.input_buffer_mut();
        frame.time = session.time();
        frame.surfaces.resize_with(session.bodies.len(), Vec::new);
        for (surface, body) in frame.surfaces.iter_mut().zip(&session.bodies) {
            surface.clear();
            surface.extend_from_slice(&body.skin.x);
        }
        frame.tools.clear();
        frame.tools.extend_from_slice(&session.frame().tools);
        self.frames.publish();
    }
}

/// Shows each new frame until told to stop.
fn show_frames(mut viewer: Box<dyn Viewer>, mut frames: Output<ViewFrame>, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        if frames.update() {
            viewer.show(frames.output_buffer_mut());
        }
        sleep(Duration::from_nanos(FRAME_PERIOD / 4));
    }
}

impl Drop for ViewerThread {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
