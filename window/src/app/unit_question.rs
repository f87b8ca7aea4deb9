//! The question for the unit of a model, where its size leaves more than one.

use super::App;
use super::panels::unit_text;
use crate::opening::ModelFacts;
use crate::strings;
use eframe::egui::{self, Align2, Color32, FontId, Rect, RichText, Sense, Stroke, pos2, vec2};
use pliant_editor::LengthUnit;

/// Length of a hand from wrist to fingertip, m (an adult's, DIN 33402-2).
const HAND: f64 = 0.19;
/// Height of the preview, points.
const PREVIEW: f32 = 84.0;
/// Share of its width that the longer bar takes.
const LONGER: f64 = 0.94;

/// Colour of the heading.
const ASKING: Color32 = Color32::from_rgb(240, 170, 40);

impl App {
    /// Whether the unit of a model that has just been opened is to be asked for: it was neither given nor is there only one with which the model has
    /// a usual size.
    pub(super) fn is_unit_unsure(&self, facts: &ModelFacts) -> bool {
        let is_new = self.request.unit.is_none() && self.request.shape.is_none() && self.script.is_none();
        facts.unit.is_some_and(|unit| is_new && LengthUnit::plausible(facts.hand.size / unit.metres()).count() != 1)
    }

    /// Whether the unit of the model is asked for.
    pub fn asks_unit(&self) -> bool {
        self.asks_unit
    }

    /// Asks for the unit, with the model beside a hand for the unit under the pointer: above the other panels, where it covers nothing of the picture.
    pub(super) fn unit_question(&mut self, ui: &mut egui::Ui) {
        let facts = self.model.as_ref().filter(|_| self.asks_unit).map(|model| &model.facts);
        let Some((unit, size)) = facts.and_then(|facts| Some((facts.unit?, facts.hand.size))) else { return };
        let extent = size / unit.metres();
        let mut chosen = None;
        ui.label(RichText::new(strings::UNIT_HEADING).heading().color(ASKING));
        ui.label(strings::unit_question(extent));
        let mut previewed = unit;
        for other in LengthUnit::ALL {
            let text = unit_text(other, extent);
            let text = if other == unit { strings::as_shown(&text) } else { text };
            let button = ui.button(text);
            if button.hovered() || button.has_focus() {
                previewed = other;
            }
            if button.clicked() {
                chosen = Some(other);
            }
        }
        preview(ui, extent * previewed.metres());
        ui.separator();
        let Some(chosen) = chosen else { return };
        self.asks_unit = false;
        self.request.unit = Some(chosen);
        if chosen != unit {
            self.reopen();
        }
    }
}

/// The lengths of the model (m) and of a hand, one under the other and to scale.
fn preview(ui: &mut egui::Ui, model: f64) {
    let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), PREVIEW), Sense::hover());
    let scale = LONGER * f64::from(response.rect.width()) / model.max(HAND);
    let colour = ui.visuals().text_color();
    let bar = |top: f32, length: f64, text: String, fill: Color32| {
        let corner = response.rect.left_top() + vec2(4.0, top);
        let end = pos2(corner.x + ((length * scale) as f32).max(1.0), corner.y + 16.0);
        painter.rect(Rect::from_two_pos(corner, end), 3.0, fill, Stroke::NONE, egui::StrokeKind::Inside);
        painter.text(corner + vec2(0.0, 18.0), Align2::LEFT_TOP, text, FontId::proportional(12.0), colour);
    };
    bar(4.0, model, pliant_editor::format_length(model), Color32::from_rgb(120, 170, 230));
    bar(44.0, HAND, strings::HAND_BESIDE.into(), Color32::from_rgb(226, 178, 140));
}
