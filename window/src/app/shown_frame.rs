//! What the frame before has shown: stages of the start, and where the hand was in it.

use super::App;
use super::model::Model;
use super::timings::{SeenHand, StartStage};
use crate::strings;

impl App {
    /// The picture of the frame before is on screen. Where that is a stage of the start, the frame after it comes at once, for its time to be known.
    pub(super) fn note_painted(&mut self) {
        let Some(stage) = self.painted.take().filter(|_| self.renderer.is_some()) else { return };
        let was_painted = self.pending.lock().is_ok_and(|mut pending| std::mem::take(&mut pending.was_painted));
        if stage == StartStage::ModelShown && !was_painted {
            return; // egui has thrown the frame away
        }
        if !self.start.reach(stage) {
            return;
        }
        if let (StartStage::ModelShown, Some(seconds)) = (stage, self.start.of(stage)) {
            self.log.event("model shown", &[("seconds", format!("{seconds:.3}"))]);
            if self.prints_timings {
                eprintln!("{}", strings::start_timings(&self.start));
            }
        }
    }

    /// Takes in where the newest frame of the simulation has the hand.
    pub(super) fn see_hand(&mut self) {
        let time = self.context.input(|input| input.time);
        let tool = self.model.as_ref().and_then(Model::tool);
        let seen =
            tool.map(|tool| SeenHand { position: tool.hand, is_in_contact: tool.contact.is_some() || tool.grips });
        let radius = self.tool_radius();
        self.latency.begin_frame(time, seen, radius);
    }

    /// Notes where the hand was sent in this frame.
    pub(super) fn track_hand(&mut self) {
        let radius = self.tool_radius();
        if let Some(model) = self.model.as_ref().filter(|model| !model.hand.is_by_device())
            && let Some(position) = model.hand.position()
        {
            self.latency.send(position, radius, model.hand.is_busy());
        }
        let is_start = self.painted_is_awaited();
        if is_start || self.latency.is_waiting() {
            self.context.request_repaint();
        }
    }

    /// Whether the picture of this frame is the first of its kind.
    fn painted_is_awaited(&self) -> bool {
        let stage = if self.model.is_some() { StartStage::ModelShown } else { StartStage::FirstFrame };
        self.renderer.is_some() && self.start.of(stage).is_none()
    }
}
