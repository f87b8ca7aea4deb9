//! A model that is being opened before there is a window: both take a while, and neither needs the other.

use super::Simulation;
use crate::opening::OpenRequest;
use eframe::egui;
use std::io;
use std::sync::{Arc, OnceLock};

/// A simulation that was started before the window that will show it.
pub struct EarlySimulation {
    simulation: io::Result<Simulation>,
    context: Arc<OnceLock<egui::Context>>,
}

impl EarlySimulation {
    /// Begins to open what is asked for. Nobody is woken until [`EarlySimulation::join`].
    pub fn start(request: OpenRequest) -> Self {
        let context = Arc::new(OnceLock::<egui::Context>::new());
        let of_thread = Arc::clone(&context);
        let wake = move || {
            if let Some(context) = of_thread.get() {
                context.request_repaint();
            }
        };
        Self { simulation: Simulation::start(request, true, None, wake), context }
    }

    /// The simulation, which wakes the window of this context from now on. What it has said until now waits for it.
    ///
    /// # Errors
    /// A system that gives no thread.
    pub fn join(self, context: &egui::Context) -> io::Result<Simulation> {
        // It is set once: `self` is gone afterwards.
        let _ = self.context.set(context.clone());
        context.request_repaint();
        self.simulation
    }
}
