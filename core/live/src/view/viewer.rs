//! A viewer on its own thread.

use super::buffer::ViewReader;
use super::frame::ViewFrame;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle, sleep};
use std::time::Duration;

/// Receives frames on its own thread; frames it is too slow for are dropped.
pub trait Viewer: Send {
    /// Shows a new frame.
    fn show(&mut self, frame: &ViewFrame);
}

/// Interval of polling for a new frame: a quarter of the time between frames.
const POLL_PERIOD: Duration = Duration::from_nanos(1_000_000_000 / 240);

/// The thread of a viewer. Dropping it ends the thread.
pub struct ViewerThread {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl ViewerThread {
    /// Shows each new frame of `reader` to a viewer.
    ///
    /// # Errors
    /// Returns the error of the system if it cannot create a thread.
    pub fn start(mut reader: ViewReader, mut viewer: Box<dyn Viewer>) -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let of_thread = Arc::clone(&stop);
        let show = move || {
            while !of_thread.load(Ordering::Relaxed) {
                if reader.update() {
                    viewer.show(reader.frame());
                }
                sleep(POLL_PERIOD);
            }
        };
        let thread = Some(Builder::new().name("viewer".into()).spawn(show)?);
        Ok(Self { stop, thread })
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
