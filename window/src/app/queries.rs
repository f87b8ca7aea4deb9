//! What the window shows, for the program around it and for tests.

use super::model::Model;
use super::timings::{PointerLatency, StartTimes};
use super::view_settings::ViewSettings;
use super::{App, Measurement};
use crate::sim::Status;
use crate::tools::{ToolKind, ToolSettings};
use crate::view::Camera;
use std::path::Path;
use std::sync::{Arc, Mutex};

impl App {
    /// Times of the start of the program.
    pub fn start_times(&self) -> &StartTimes {
        &self.start
    }

    /// How soon the picture shows what the pointer does.
    pub fn pointer_latency(&self) -> &PointerLatency {
        &self.latency
    }

    /// Where the result of a measurement will be.
    pub fn measurement(&self) -> Arc<Mutex<Option<Measurement>>> {
        Arc::clone(&self.measured)
    }

    /// The newest strokes and gauges.
    pub fn status(&self) -> &Status {
        &self.status
    }

    /// Number of messages so far.
    pub fn message_count(&self) -> usize {
        self.messages.len()
    }

    /// The newest message.
    pub fn last_message(&self) -> Option<&str> {
        self.messages.last().map(|(_, text)| text.as_str())
    }

    /// The error that is shown.
    pub fn error(&self) -> Option<&str> {
        self.error.as_deref()
    }

    /// The file that is open or to be opened.
    pub fn path(&self) -> &Path {
        &self.request.path
    }

    /// Whether a stroke is under way: from the press of the button until the hand has done what was drawn.
    pub fn is_stroke_under_way(&self) -> bool {
        self.model.as_ref().is_some_and(|model| model.hand.is_busy())
    }

    /// Whether a model is open.
    pub fn is_open(&self) -> bool {
        self.model.is_some()
    }

    /// Tints of the drawn vertices that are pinned or painted, as [`pliant_engine::body::Body::tints`].
    pub fn tints(&self) -> impl Iterator<Item = f32> + '_ {
        self.model.iter().flat_map(Model::tints)
    }

    /// The tool and how it is set.
    pub fn tool(&self) -> (ToolKind, ToolSettings) {
        (self.tools[self.tool], self.settings)
    }

    /// Where the model is seen from.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// How the model is shown.
    pub fn view(&self) -> ViewSettings {
        self.view
    }

    /// Whether there are strokes that have not been saved.
    pub fn is_unsaved(&self) -> bool {
        self.saved_shape != Some(self.status.shape)
    }
}
