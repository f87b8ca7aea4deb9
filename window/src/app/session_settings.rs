//! Size, strength and symmetry of the tool, and the stiffness of the model: what is set in the window and sent to the session.

use super::App;
use crate::sim::Command;
use crate::tools::ToolSettings;
use pliant_engine::session::SessionCommand;

/// Factors of the stiffness that may be asked for while a model is open.
const STIFFNESS_FACTORS: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

impl App {
    /// Gives the tool of the session the size that is set.
    pub(super) fn resize_tool(&mut self) {
        let Some(model) = &self.model else { return };
        let hand = model.facts.hand;
        // A larger ball meets more of the surface, so the spring to the hand grows as the contact does: with the radius.
        let (radius, coupling) = (self.settings.size * hand.radius, self.settings.size * hand.coupling);
        self.send(Command::ChangeBrush(SessionCommand::ResizeTools { radius, coupling }));
    }

    /// Gives the edits of the session the strength and the falloff that are set.
    pub(super) fn set_brush(&mut self) {
        let ToolSettings { brush, falloff, .. } = self.settings;
        self.send(Command::ChangeBrush(SessionCommand::SetBrush { strength: brush, falloff }));
    }

    /// Gives the session the symmetry that is set; what is under way keeps its own.
    pub(super) fn send_symmetry(&mut self) {
        let wanted = self.settings.symmetry;
        let Some(model) = &self.model else { return };
        if wanted != self.sent_symmetry {
            self.send(Command::ChangeBrush(SessionCommand::SetSymmetry {
                axes: wanted,
                centre: model.symmetry(wanted).centre,
            }));
            self.sent_symmetry = wanted;
        }
    }

    /// Asks for a stiffness, as a factor of that at the opening.
    pub(super) fn stiffen(&mut self, factor: f64) {
        self.follows_stiffness = false;
        self.take_stiffness(factor.clamp(*STIFFNESS_FACTORS.start(), *STIFFNESS_FACTORS.end()));
        self.send(Command::SetStiffness { factor: self.stiffness });
    }

    /// Shows a stiffness as the one that is asked for.
    pub(super) fn take_stiffness(&mut self, factor: f64) {
        if self.stiffness == factor {
            return;
        }
        self.stiffness = factor;
        if let Some(young) = self.opened_young {
            self.request.solid.young = young * factor;
        }
    }

    /// Radius of the tool, m; 0 without a model.
    pub fn tool_radius(&self) -> f64 {
        self.settings.size * self.model.as_ref().map_or(0.0, |model| model.facts.hand.radius)
    }
}
